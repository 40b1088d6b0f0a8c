// Names of parameters as paths through the tree, for overrides, rules and messages alike.
// An element of a list is addressed by its name (stage.passage.duration), since numbers change when
// an element is inserted; messages show the number.
#include <charconv>
#include <utility>

#include "input/tree.hpp"

namespace trackbed::input {

// Points and brackets are equivalent separators. Empty words are kept: `put` rejects them.
// "ground.layer[1].young" and "ground.layer.1.young" give the same words.
std::vector<std::string> words_of(std::string_view path) {
  std::vector<std::string> words(1);
  for (const char c : path) {
    if (c == ']') continue;
    if (c == '.' || c == '[')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

// By name first: a name that is a number takes precedence over an index.
const Node* element(const Node& list, const std::string& word) {
  for (const Node& item : list.items) {
    const Node* name = item.is_table() ? item.member("name") : nullptr;
    if (name != nullptr && name->kind == Node::Kind::text && name->text == word) return &item;
  }
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  // All characters must be digits: "2x" is a name.
  const bool number = error == std::errc() && end == word.data() + word.size();
  return number && index < list.items.size() ? &list.items[index] : nullptr;
}

// One search for both; casting const away is sound, since the list is not const here.
Node* element(Node& list, const std::string& word) {
  return const_cast<Node*>(element(std::as_const(list), word));
}

// Follows the path as far as it exists: a rule about a parameter that is not in the deck refers to
// its section.
Place follow(const Node& root, std::string_view path) {
  const Node* node = &root;
  for (const std::string& word : words_of(path)) {
    const Node* const next = node->is_list() ? element(*node, word) : node->member(word);
    if (next == nullptr) return {node, false};
    node = next;
  }
  return {node, true};
}

}  // namespace trackbed::input
