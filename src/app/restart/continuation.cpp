#include "app/restart/continuation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "app/deck/deck_files.hpp"
#include "app/restart/compatible.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::app {

namespace {

// A finished run of a track may have no checkpoint; its results have its deck, too.
io::File file_with_deck(const par::Comm& comm, const std::string& folder) {
  if (!has_checkpoint(comm, folder)) return observe::open_results(comm, folder + "/results.h5");
  return io::open_checkpoint(comm,
                             io::choose_checkpoint(comm, folder, io::IfDamaged::pass_over).file);
}

// Rows that only one of the decks has, such as another stage.
std::vector<std::string> rows_of_one(const Values& then, const Values& now) {
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now)
    if (!then.contains(key))
      sentences.push_back(fmt::format("{} = {} (previously none)", key, value));
  for (const auto& [key, value] : then)
    if (!now.contains(key))
      sentences.push_back(fmt::format("{} is missing (previously {})", key, value));
  return sentences;
}

void require_none(const std::string& folder, std::vector<std::string> differences) {
  if (differences.empty()) return;
  constexpr std::size_t shown = 5;
  const std::size_t more = differences.size() - std::min(differences.size(), shown);
  differences.resize(differences.size() - more);
  throw InputError({fmt::format(
      "{}: holds a run of another input, which --or-resume does not continue: {}{}; choose another "
      "folder (-o DIR), continue that run (trackbed resume {}), or have its results removed "
      "(--force)",
      folder, fmt::join(differences, ", "), more > 0 ? fmt::format(" and {} more", more) : "",
      folder)});
}

std::vector<std::string> differences_of(const Values& then, const Values& now) {
  std::vector<std::string> differences = changes(then, now);
  for (const std::string& row : rows_of_one(then, now)) differences.push_back(row);
  return differences;
}

}  // namespace

bool has_checkpoint(const par::Comm& comm, const std::string& folder) {
  try {
    io::choose_checkpoint(comm, folder, io::IfDamaged::pass_over);
    return true;
  } catch (const InputError&) {  // equal on all ranks
    return false;
  }
}

std::vector<std::string> overrides_of_same_run(const par::Comm& comm, const std::string& folder,
                                               const model::Model& model) {
  const std::string effective = model::effective_deck(model);
  const Values now = values_of(effective);
  const io::File file = file_with_deck(comm, folder);
  const Values then = with_moved_files(comm, file, stored_values(file, now), effective);
  std::vector<std::string> differences = differences_of(then, now);
  std::vector<std::string> overrides = changes_without_effect(then, now);
  // A finished passage is made longer from its last checkpoint.
  if (!has_checkpoint(comm, folder))
    for (const std::string& word : overrides)
      if (word.starts_with("passage.duration=")) differences.push_back(word);
  require_none(folder, differences);
  return overrides;
}

void require_of_same_run(const par::Comm& comm, const std::string& folder,
                         const model::Model& model) {
  const std::string results = folder + "/results.h5";
  std::error_code ignored;
  const bool there = comm.root() && std::filesystem::exists(results, ignored);
  if (comm.broadcast(there ? "there" : "").empty()) return;
  const Values now = values_of(model::effective_deck(model));
  require_none(folder,
               differences_of(stored_values(observe::open_results(comm, results), now), now));
}

}  // namespace trackbed::app
