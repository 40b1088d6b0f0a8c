// Which runs of a track alone can be continued, and with which changes of their input.
//
// The state is the motion of a model that is built again from the deck, and depends on nearly every
// parameter. The duration may change, when the run stops or writes checkpoints, and the tolerance
// of contacts. Another interval of histories is refused, since rows are counted in steps from the
// start.
#include "app/restart/track_resume.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "app/deck/deck_files.hpp"
#include "app/restart/compatible.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/model/checks.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

constexpr std::array free_to_change = {"passage.duration", "passage.tolerance",
                                       "output.checkpoint_interval", "output.wall_time",
                                       "output.stop_after"};

bool is_free(std::string_view key) {
  for (const char* known : free_to_change)
    if (key == known) return true;
  return key == "title";
}

// The summary in a folder; on rank 0. Empty if the file is not a summary.
nlohmann::json summary_in(const fs::path& folder) {
  std::stringstream text;
  text << std::ifstream(folder / "summary.json").rdbuf();
  const auto summary = nlohmann::json::parse(text.str(), nullptr, false);
  return summary.is_object() ? summary : nlohmann::json::object();
}

}  // namespace

// Rank 0 reads the folder; the summary states the kind of run.
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
    throw InputError({found + ": contains a run of a track alone without a checkpoint; such a run "
                              "writes checkpoints only when it is stopped, or every "
                              "output.checkpoint_interval: run the deck again"});
}

// All tables and keys of both decks are compared, so that a missing one counts as a difference. A
// finished run may be made longer; the part after the checkpoint is then computed again.
bool is_track_left(const par::Comm& comm, const std::string& checkpoint,
                   const model::TrackModel& model, const std::string& effective,
                   const input::Deck& deck) {
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
    problems.push_back(fmt::format("{} {}: the run in {} was made {}; both must be equal",
                                   deck.where(key), gone ? "is missing" : "= " + new_one->second,
                                   checkpoint,
                                   is_new ? "without this parameter" : "with " + old_one->second));
  }
  for (const auto& [key, sentence] : changed_files(comm, file, checkpoint, effective, deck))
    problems.push_back(sentence);
  if (!problems.empty()) throw InputError(problems);
  require_files(model);
  const bool reported =
      comm.root() && summary_in(fs::path(checkpoint).parent_path()).value("finished", false);
  return changed || comm.broadcast(reported ? "reported" : "").empty();
}

// They are read again when the model is built; they are small.
void require_files(const model::TrackModel& model) {
  for (const auto* one : {&model.irregularity, &model.irregularity_right})
    if (one->kind == track::IrregularityKind::file)
      track::Irregularity(*one, model.line.track.length);
  model::seats_of(model);
}

}  // namespace trackbed::app
