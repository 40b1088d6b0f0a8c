// A deck's text as a tree of plain values that remember their line: what the rest of the room sees
// of TOML. Private to the room.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace trackbed::input {

// One struct for all kinds: only the member that `kind` names means anything; of a single value of
// the command line `text` too, its words. A variant would be smaller, but a deck has a few hundred
// values.
struct Node {
  enum class Kind { table, list, number, integer, flag, text, other };

  Kind kind = Kind::table;
  double number = 0;
  std::int64_t integer = 0;
  bool flag = false;
  std::string text;
  std::vector<std::pair<std::string, Node>> members;  // of a table, in the order of the file
  std::vector<Node> items;                            // of a list
  int line = 0;                                       // 0: not in the file
  bool commanded = false;                             // given on the command line

  bool is_table() const { return kind == Kind::table; }
  bool is_list() const { return kind == Kind::list; }
  // Not a section or a list of them, which nobody wants to read in a message.
  bool is_value() const {
    return !is_table() && !(is_list() && !items.empty() && items.front().is_table());
  }
  const Node* member(std::string_view name) const;
  Node* member(std::string_view name);
};

// "stage.passage.duration", "layer[1].young" -> the words between the points; an index is a word.
// Bracket or point: both lead into a list.
std::vector<std::string> words_of(std::string_view path);
// The element of a list that `word` means: by its `name`, else by its number. Null if none.
Node* element(Node& list, const std::string& word);
const Node* element(const Node& list, const std::string& word);
// What `path` leads to from `root`, or the innermost section on the way that exists.
// Never null: the root, if nothing on the way exists.
struct Place {
  const Node* node;
  bool reached;
};
Place follow(const Node& root, std::string_view path);

// Throws InputError with `origin:line:` for text that is not TOML. `origin` names it in messages.
Node parse_toml(const std::string& text, const std::string& origin);
// The value of an override: TOML, else the words themselves as text.
// Never throws: what is no TOML value is text.
Node parse_value(const std::string& text);

// As it would be written in a deck: `"x"`, `[1, 2]`; numbers keep all their bits.
std::string shown(const Node& node);
// A number for people: 5, 0.001, 1e+09.
std::string shown(double value);
// A whole deck: values first, then sections.
std::string deck_text(const Node& root);

Node make_number(double value);
Node make_integer(std::int64_t value);
Node make_flag(bool value);
Node make_text(std::string value);
Node make_list(std::vector<Node> items);

}  // namespace trackbed::input
