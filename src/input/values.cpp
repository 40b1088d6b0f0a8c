// Not parsed as TOML: a stored deck may no longer be valid, for example because a table beside it
// is missing, and its text is simple: no comments, no line breaks within values.
//
// Tables of the same name are numbered in their order, as in the deck.
#include "trackbed/input/values.hpp"

#include <fmt/format.h>

#include <sstream>

namespace trackbed::input {

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
      section = line.substr(1, line.find(']') - 1) + ".";
    } else if (const std::size_t sign = line.find(" = "); sign != std::string::npos) {
      values[section + line.substr(0, sign)] = line.substr(sign + 3);
    }
  }
  return values;
}

}  // namespace trackbed::input
