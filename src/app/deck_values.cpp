// Not parsed as TOML again: a stored deck need not be valid any more, e.g. because a table beside
// it is gone, and its text is of the plainest kind: no comments, no line breaks within values.
//
// Tables of the same name are numbered in the order they stand in, as the deck numbers them.
#include "app/deck_values.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "trackbed/core/hash.hpp"

namespace trackbed::app {

Values values_of(const std::string& effective) {
  Values values;
  std::map<std::string, int> elements;
  std::istringstream lines(effective);
  std::string line, section;
  while (std::getline(lines, line)) {
    // Three kinds of line; anything else (blank lines) holds no value.
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

// Any text that names a file counts: a title that does is of no weight to a state.
std::string contents_of_files(const par::Comm& comm, const std::string& effective) {
  std::string text;
  for (const auto& [key, value] : comm.root() ? values_of(effective) : Values{}) {
    if (value.size() < 3 || value.front() != '"' || key == "start") continue;
    const std::string path = value.substr(1, value.size() - 2);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) continue;
    std::ifstream file(path, std::ios::binary);
    std::uint64_t hash = hash_bytes("", 0);
    std::vector<char> part(1 << 20);
    while (file.read(part.data(), static_cast<std::streamsize>(part.size())) || file.gcount() > 0)
      hash = hash_bytes(part.data(), static_cast<std::size_t>(file.gcount()), hash);
    text += fmt::format("{} = {:016x}\n", key, hash);
  }
  return comm.broadcast(text);
}

// Both are decks of the same stages and tables: keys of one are those of the other.
std::vector<std::string> changes(const Values& before, const Values& now) {
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    const auto old = before.find(key);
    if (old == before.end() || old->second == value || key.starts_with("output.")) continue;
    sentences.push_back(fmt::format("{} = {}, before {}", key, value, old->second));
  }
  return sentences;
}

}  // namespace trackbed::app
