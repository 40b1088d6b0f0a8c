// Which runs of a track alone can go on, and with which changes of their input.
//
// The state is motion of a model that the deck makes anew, so nearly every parameter made it.
// What may change is how long the run goes on, when it stops or writes checkpoints, and how exactly
// contacts are solved. Refused rather than allowed: another interval of histories, whose rows are
// counted in steps from the begin.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "app/compatible.hpp"
#include "app/deck_files.hpp"
#include "app/track_run.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

constexpr std::array free_to_change = {"passage.duration", "passage.tolerance",
                                       "passage.checkpoint_interval", "passage.wall_time",
                                       "passage.stop_after"};

bool is_free(std::string_view key) {
  for (const char* known : free_to_change)
    if (key == known) return true;
  return key == "title";
}

// Of a folder; on rank 0. A file that is no summary says nothing.
nlohmann::json summary_in(const fs::path& folder) {
  std::stringstream text;
  text << std::ifstream(folder / "summary.json").rdbuf();
  const auto summary = nlohmann::json::parse(text.str(), nullptr, false);
  return summary.is_object() ? summary : nlohmann::json::object();
}

}  // namespace

// Rank 0 looks; the summary says what kind of run it was.
void require_track_checkpoint(const par::Comm& comm, const std::string& path) {
  std::string found;
  if (comm.root()) {
    const fs::path folder = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
    if (summary_in(folder).value("model", "").starts_with("track") &&
        !fs::exists(folder / "latest"))
      found = folder.string();
  }
  found = comm.broadcast(found);
  if (!found.empty())
    throw InputError({found + ": holds a run of a track alone without a checkpoint, which such a "
                              "run writes when it is stopped, or every "
                              "passage.checkpoint_interval: run the deck again"});
}

// Every table and key of either deck, so that one that is gone counts as much as a new one. A run
// that is finished may be made longer, and what of it came after the checkpoint is done again.
bool is_track_left(const par::Comm& comm, const std::string& checkpoint, const TrackModel& model,
                   const std::string& effective, const input::Deck& deck) {
  const io::File file = io::open_checkpoint(comm, checkpoint);
  const Values now = values_of(effective),
               then = with_moved_files(comm, file, stored_values(file, now), effective);
  Values all = now;
  all.insert(then.begin(), then.end());
  std::vector<std::string> problems;
  bool changed = false;
  for (const auto& [key, value] : all) {
    const auto new_one = now.find(key), old_one = then.find(key);
    const bool gone = new_one == now.end(), is_new = old_one == then.end();
    if (!gone && !is_new && new_one->second == old_one->second) continue;
    changed = true;
    if (is_free(key)) continue;
    problems.push_back(fmt::format("{} {}: the run in {} was made {}", deck.where(key),
                                   gone ? "is not there" : "= " + new_one->second, checkpoint,
                                   is_new ? "without it" : "with " + old_one->second));
  }
  for (const auto& [key, sentence] : changed_files(comm, file, checkpoint, effective, deck))
    problems.push_back(sentence);
  const std::int64_t done = file.read_all<std::int64_t>("train/counts").at(0);
  // The one that stopped the run stands in its deck and is no wish to stop again.
  const std::string stop = deck.where("passage.stop_after");
  if (stop.starts_with("command line") && model.passage.stop_after > 0 &&
      model.passage.stop_after <= done)
    problems.push_back(fmt::format("{} = {} steps: {} are done already; give more, or 0", stop,
                                   model.passage.stop_after, done));
  if (!problems.empty()) throw InputError(problems);
  require_files(model);
  const bool told =
      comm.root() && summary_in(fs::path(checkpoint).parent_path()).value("finished", false);
  return changed || comm.broadcast(told ? "told" : "").empty();
}

std::vector<std::string> changed_on_resumes(const par::Comm& comm, const io::File& checkpoint,
                                            const std::string& effective) {
  std::vector<std::string> sentences;
  if (checkpoint.has_attribute("/", "changed")) {
    std::istringstream lines(checkpoint.text_attribute("/", "changed"));
    for (std::string line; std::getline(lines, line);) sentences.push_back(line);
  }
  Values now = values_of(effective);
  for (const char* key : {"title", "passage.duration", "passage.stop_after", "passage.wall_time",
                          "passage.checkpoint_interval"})
    now.erase(key);
  const double time = checkpoint.number_attribute("/", "time");
  const Values then = with_moved_files(comm, checkpoint, stored_values(checkpoint, now), effective);
  for (const std::string& change : changes(then, now))
    sentences.push_back(
        fmt::format("from {:.6g} s on, where the run was resumed: {}", time, change));
  return sentences;
}

}  // namespace trackbed::app
