// The only file that includes toml++ (https://marzer.github.io/tomlplusplus), a large header that
// is so compiled once.
//
// The parser's tree is converted as a whole and then freed: our nodes outlive it, can be changed by
// overrides and record whether they came from the command line.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>

#include "input/tree.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::input {

namespace {

Node converted(const toml::node& source, std::string_view document);

Node converted_table(const toml::table& source, std::string_view document) {
  Node node;
  for (const auto& [key, value] : source)
    node.members.push_back({std::string(key.str()), converted(value, document)});
  // toml++ sorts by name; the order of the file is restored.
  std::stable_sort(node.members.begin(), node.members.end(),
                   [](const auto& a, const auto& b) { return a.value.line < b.value.line; });
  return node;
}

// Items may be of any kind; the reader checks them. Words are kept in sections only: to find those
// of each number of a list would take as long as the square of its length.
Node converted_list(const toml::array& source, std::string_view document) {
  Node node;
  node.kind = Node::Kind::list;
  for (const auto& item : source)
    node.items.push_back(converted(item, item.is_table() ? document : std::string_view()));
  return node;
}

// What a document says from one position to another of a line, of which columns count characters.
std::string words_of(const toml::source_region& region, std::string_view document) {
  for (toml::source_index line = 1; line < region.begin.line; ++line)
    document.remove_prefix(std::min(document.find('\n'), document.size() - 1) + 1);
  std::string words;
  toml::source_index column = 0;
  for (const char c : document.substr(0, document.find('\n'))) {
    column += (static_cast<unsigned char>(c) & 0xc0) != 0x80;  // other bytes continue a character
    if (column >= region.begin.column && column < region.end.column) words += c;
  }
  return words;
}

// TOML's integers have 64 bits and its numbers are doubles: nothing is rounded here.
Node converted_scalar(const toml::node& source) {
  if (const auto* value = source.as_floating_point()) return make_number(value->get());
  if (const auto* value = source.as_integer()) return make_integer(value->get());
  if (const auto* value = source.as_boolean()) return make_flag(value->get());
  if (const auto* value = source.as_string()) return make_text(value->get());
  Node date;  // a date or time, which no parameter accepts
  date.kind = Node::Kind::other;
  return date;
}

// Line numbers are kept, since every message about a value begins with its line.
Node converted(const toml::node& source, std::string_view document) {
  Node node;
  if (const auto* table = source.as_table())
    node = converted_table(*table, document);
  else if (const auto* list = source.as_array())
    node = converted_list(*list, document);
  else
    node = converted_scalar(source);
  if (node.is_value() && !node.is_list() && node.kind != Node::Kind::text)
    node.text = words_of(source.source(), document);
  node.line = static_cast<int>(source.source().begin.line);
  // A section that is defined only by its sub-sections has no line: use that of the first one.
  if (node.line == 0 && node.is_table() && !node.members.empty())
    node.line = node.members.front().value.line;
  if (node.line == 0 && node.is_list() && !node.items.empty()) node.line = node.items.front().line;
  return node;
}

// What is most likely meant by a line that is not TOML, or nothing.
std::string hint(const std::string& line, std::string_view problem) {
  static const std::regex comma(R"(\s*[\w.]+\s*=\s*[-+]?\d+,\d+\s*(#.*)?)");
  static const std::regex unit(R"(\s*([\w.]+)\s*=\s*[-+]?[\d.]+(e[-+]?\d+)?\s*[A-Za-z%].*)");
  std::smatch match;
  if (std::regex_match(line, comma)) return "; decimals are written with a point";
  if (std::regex_match(line, match, unit))
    return fmt::format("; give the number alone, in the unit that `trackbed describe {}` states",
                       match[1].str());
  if (problem.find("redefine existing table") != problem.npos ||
      problem.find("redefine existing array") != problem.npos)
    return "; the tables of a list have two brackets, such as [[material]]";
  return "";
}

std::string line_of(const std::string& text, toml::source_index number) {
  std::istringstream lines(text);
  std::string line;
  for (toml::source_index k = 0; k < number; ++k) std::getline(lines, line);
  return line;
}

}  // namespace

// The parser stops at the first error, so invalid TOML causes one message only.
Node parse_toml(const std::string& text, const std::string& origin) {
  try {
    return converted_table(toml::parse(std::string_view(text)), text);
  } catch (const toml::parse_error& error) {
    const toml::source_index line = error.source().begin.line;
    throw InputError(
        {fmt::format("{}:{}: {}{}", origin, static_cast<int>(line), error.description(),
                     hint(line_of(text, line), error.description()))});
  }
}

// A shell removes quotes: base=viscous must mean the text as base = "viscous" does in a deck. So a
// value that is not TOML is text; a wrong type is detected by the reader.
Node parse_value(const std::string& text) {
  try {
    const std::string document = "value = " + text;
    const toml::table table = toml::parse(document);
    // More than one key: the text contained a line break and is not one value.
    if (table.size() == 1 && table.contains("value"))
      return converted(*table.get("value"), document);
  } catch (const toml::parse_error&) {
  }
  return make_text(text);
}

}  // namespace trackbed::input
