// Not parsed as TOML: a stored deck may no longer be valid, for example because a table beside it
// is missing, and its text is simple: no comments, no line breaks within values.
//
// Tables of the same name are numbered in their order, as in the deck.
#include "app/deck/deck_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>

namespace trackbed::app {

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

namespace {

constexpr std::array when_to_stop = {"output.wall_time", "output.stop_after",
                                     "output.checkpoint_interval"};

}  // namespace

// Both are decks of the same stages and tables: keys of one are those of the other.
std::vector<std::string> changes(const Values& before, const Values& now) {
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    const auto old = before.find(key);
    if (old == before.end() || old->second == value ||
        std::find(when_to_stop.begin(), when_to_stop.end(), key) != when_to_stop.end())
      continue;
    sentences.push_back(fmt::format("{} = {}, before {}", key, value, old->second));
  }
  return sentences;
}

}  // namespace trackbed::app
