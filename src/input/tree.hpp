// A deck's text as a tree of plain values with their line numbers: the module's own view of TOML.
// Private to the module.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace trackbed::input {

// One struct for all kinds: only the member of `kind` is meaningful; `text` also holds the words of
// a single value that was read, unless it is in a list. A variant would be smaller, but a deck has
// only a few hundred values.
struct Member;
struct Node {
  enum class Kind { table, list, number, integer, flag, text, other };

  Kind kind = Kind::table;
  double number = 0;
  std::int64_t integer = 0;
  bool flag = false;
  std::string text;
  std::vector<Member> members;  // of a table, in the order of the file
  std::vector<Node> items;      // of a list
  int line = 0;                 // 0: not in the file
  bool from_override = false;   // given on the command line

  bool is_table() const { return kind == Kind::table; }
  bool is_list() const { return kind == Kind::list; }
  // Neither a section nor a list of sections, which are too long for a message.
  bool is_value() const {
    return !is_table() && !(is_list() && !items.empty() && items.front().is_table());
  }
  const Node* member(std::string_view name) const;
  Node* member(std::string_view name);
};

struct Member {
  std::string name;
  Node value;
};

// "stage.passage.duration", "layer[1].young" -> the words between the points; an index is a word.
// Brackets and points are equivalent.
std::vector<std::string> words_of(std::string_view path);
// The element of a list named `word`: by its `name`, else by its index. Null if none.
Node* element(Node& list, const std::string& word);
const Node* element(const Node& list, const std::string& word);
// The node at `path` from `root`, or the innermost existing section along the path. Never null: the
// root, if nothing along the path exists.
struct Place {
  const Node* node;
  bool reached;
};
Place follow(const Node& root, std::string_view path);

// Throws InputError with `origin:line:` for text that is not TOML. `origin` names it in messages.
Node parse_toml(const std::string& text, const std::string& origin);
// The value of an override: TOML, else the words as text. Never throws: anything that is not a TOML
// value is text.
Node parse_value(const std::string& text);

// As it would be written in a deck: `"x"`, `[1, 2]`; numbers are exact.
std::string shown(const Node& node);
// A number in short form: 5, 0.001, 1e+09.
std::string shown(double value);
// A whole deck: values first, then sections.
std::string deck_text(const Node& root);

Node make_number(double value);
Node make_integer(std::int64_t value);
Node make_flag(bool value);
Node make_text(std::string value);
Node make_list(std::vector<Node> items);

}  // namespace trackbed::input
