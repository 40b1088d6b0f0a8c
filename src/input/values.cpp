// Not parsed as TOML: a stored deck may no longer be valid, for example because a table beside it
// is missing, and its text is simple: no comments, no line breaks within values.
//
// Tables of the same name are numbered in their order, as in the deck.
#include "trackbed/input/values.hpp"

#include <fmt/format.h>

#include <sstream>

namespace trackbed::input {

namespace {

// A table within an element of a list is that of the present element: [stone.polyhedron] after the
// second [[stone]] is stone[1].polyhedron.
std::string numbered(const std::string& name, const std::map<std::string, int>& elements) {
  for (std::size_t dot = name.rfind('.'); dot != name.npos && dot > 0;
       dot = name.rfind('.', dot - 1))
    if (const auto list = elements.find(name.substr(0, dot)); list != elements.end())
      return fmt::format("{}[{}]{}", list->first, list->second - 1, name.substr(dot));
  return name;
}

}  // namespace

Values values_of(const std::string& effective) {
  Values values;
  std::map<std::string, int> elements;
  std::istringstream lines(effective);
  std::string line, section;
  while (std::getline(lines, line)) {
    // Three kinds of line; any other (a blank line) contains no value.
    if (line.starts_with("[[")) {
      const std::string name = line.substr(2, line.find(']') - 2);
      section = fmt::format("{}[{}].", name, elements[name]++);
    } else if (line.starts_with('[')) {
      section = numbered(line.substr(1, line.find(']') - 1), elements) + ".";
    } else if (const std::size_t sign = line.find(" = "); sign != std::string::npos) {
      values[section + line.substr(0, sign)] = line.substr(sign + 3);
    }
  }
  return values;
}

}  // namespace trackbed::input
