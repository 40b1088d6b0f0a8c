// Writes values as TOML. Every value reads back bitwise identical.
// A checkpoint stores its deck in this form, and compatible.cpp compares decks by it: equal values
// must have equal texts.
#include "input/tree.hpp"

#include <fmt/format.h>

#include <cmath>

namespace trackbed::input {

namespace {

// TOML basic strings: characters that are not allowed are escaped, other bytes (UTF-8) are kept.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += fmt::format("\\{}", c);
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else if (code < 0x20 || code == 0x7f)
      out += fmt::format("\\u{:04x}", code);
    else
      out += c;
  }
  return out + '"';
}

// Shortest digits that read back to the identical double; a point keeps -0.0 from reading as
// integer 0. A number such as 1e30 has an exponent already and needs no point.
std::string exact(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::string digits = fmt::format("{}", value);
  if (digits.find_first_of(".e") == std::string::npos) digits += ".0";
  return digits;
}

std::string shown_list(const Node& node) {
  std::string out = "[";
  for (const Node& item : node.items) out += (out.size() > 1 ? ", " : "") + shown(item);
  return out + "]";
}

// Values before sections: in TOML a value after a header would belong to that section. Lists of
// sections repeat their header before each element. A list without elements is printed as a value,
// `[]`, or it would be lost when read back.
void print_table(const Node& table, const std::string& path, std::string& out) {
  for (const auto& [name, value] : table.members)
    if (value.is_value()) out += fmt::format("{} = {}\n", name, shown(value));
  for (const auto& [name, value] : table.members) {
    const std::string full = path.empty() ? name : fmt::format("{}.{}", path, name);
    if (value.is_table()) {
      out += fmt::format("\n[{}]\n", full);
      print_table(value, full, out);
    } else if (!value.is_value()) {
      for (const Node& item : value.items) {
        out += fmt::format("\n[[{}]]\n", full);
        print_table(item, full, out);
      }
    }
  }
}

}  // namespace

// One search for both: the const_cast is safe, since *this is not const here.
const Node* Node::member(std::string_view name) const {
  for (const auto& [key, value] : members)
    if (key == name) return &value;
  return nullptr;
}
Node* Node::member(std::string_view name) {
  return const_cast<Node*>(static_cast<const Node*>(this)->member(name));
}

// The type is not kept: 5.0 is shown as 5.
std::string shown(double value) { return fmt::format("{}", value); }

// One line for any node: for messages and for values of the effective deck.
std::string shown(const Node& node) {
  switch (node.kind) {
    case Node::Kind::number:
      return exact(node.number);
    case Node::Kind::integer:
      return fmt::format("{}", node.integer);
    case Node::Kind::flag:
      return node.flag ? "true" : "false";
    case Node::Kind::text:
      return quoted(node.text);
    case Node::Kind::list:
      return shown_list(node);
    // A whole section is too long for a message.
    case Node::Kind::table:
      return "{...}";
    case Node::Kind::other:
      break;
  }
  return node.text;
}

// Local, a pure function: equal trees give equal texts.
std::string deck_text(const Node& root) {
  std::string out;
  print_table(root, "", out);
  return out;
}

// Created by the program, not read from a file: without a line.
Node make_number(double value) {
  Node node;
  node.kind = Node::Kind::number, node.number = value;
  return node;
}
Node make_integer(std::int64_t value) {
  Node node;
  node.kind = Node::Kind::integer, node.integer = value;
  return node;
}
Node make_flag(bool value) {
  Node node;
  node.kind = Node::Kind::flag, node.flag = value;
  return node;
}
Node make_text(std::string value) {
  Node node;
  node.kind = Node::Kind::text, node.text = std::move(value);
  return node;
}
Node make_list(std::vector<Node> items) {
  Node node;
  node.kind = Node::Kind::list, node.items = std::move(items);
  return node;
}

}  // namespace trackbed::input
