// Hashes of whole files: a mesh file with one more comment counts as another file. Rejected: a
// comparison of the data that are read, which every reader would have to support.
#include "app/deck/deck_files.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "trackbed/core/hash.hpp"

namespace trackbed::app {

namespace {

// Whether a text parameter that names a file is read as a file: a title is not, nor the file of an
// irregularity of another kind.
bool is_read(const Values& values, const std::string& key) {
  if (key == "title" || key == "start" || key == "bed.cell") return false;
  const std::size_t dot = key.rfind(".file");
  if (!key.starts_with("irregularity") || dot == key.npos) return true;
  const auto kind = values.find(key.substr(0, dot) + ".kind");
  return kind != values.end() && kind->second == "\"file\"";
}

}  // namespace

std::string contents_of_files(const par::Comm& comm, const std::string& effective) {
  std::string text;
  const Values values = comm.root() ? values_of(effective) : Values{};
  for (const auto& [key, value] : values) {
    if (value.size() < 3 || value.front() != '"' || !is_read(values, key)) continue;
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

namespace {

// Hashes by key of both; empty if the program that wrote the checkpoint did not store any.
// Collective.
struct Hashes {
  Values then, now;
};
Hashes hashes_of(const par::Comm& comm, const io::File& checkpoint, const std::string& effective) {
  if (!checkpoint.has_attribute("/", "files")) return {};
  return {values_of(checkpoint.text_attribute("/", "files")),
          values_of(contents_of_files(comm, effective))};
}

}  // namespace

Values with_moved_files(const par::Comm& comm, const io::File& checkpoint, Values then,
                        const std::string& effective) {
  const Values now = values_of(effective);
  const Hashes hashes = hashes_of(comm, checkpoint, effective);
  for (const auto& [key, hash] : hashes.now) {
    const auto old = hashes.then.find(key);
    if (old != hashes.then.end() && old->second == hash) then[key] = now.at(key);
  }
  return then;
}

std::map<std::string, std::string> changed_files(const par::Comm& comm, const io::File& checkpoint,
                                                 const std::string& path,
                                                 const std::string& effective,
                                                 const input::Deck& deck) {
  const Hashes hashes = hashes_of(comm, checkpoint, effective);
  const Values deck_then = values_of(checkpoint.text_attribute("/", "deck"));
  const Values deck_now = values_of(effective);
  std::map<std::string, std::string> sentences;
  for (const auto& [key, hash] : hashes.now) {
    const auto old = hashes.then.find(key), name = deck_then.find(key);
    if (old == hashes.then.end() || old->second == hash || name == deck_then.end()) continue;
    const std::string& now = deck_now.at(key);
    if (name->second != now) continue;  // another file: reported as a changed value
    sentences[key] = fmt::format(
        "{} = {}: the content of the file has changed since {} was written; restore the file, or "
        "start a new run without this checkpoint",
        deck.where(key), now, path);
  }
  return sentences;
}

}  // namespace trackbed::app
