// Which runs of a track, alone or on a ground, can be continued: those with a checkpoint whose
// parameters are the same, except for the few that `free_to_change` declares. Another interval of
// histories is refused, since rows are counted in steps from the start.
#include "app/restart/track_resume.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/restart/compatible.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/model/checks.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

// The summary in a folder; on rank 0. Empty if the file is not a summary.
nlohmann::json summary_in(const fs::path& folder) {
  std::stringstream text;
  text << std::ifstream(folder / "summary.json").rdbuf();
  const auto summary = nlohmann::json::parse(text.str(), nullptr, false);
  return summary.is_object() ? summary : nlohmann::json::object();
}

}  // namespace

bool is_finished(const std::string& folder) {
  const nlohmann::json summary = summary_in(folder);
  const auto finished = summary.find("finished");
  return finished != summary.end() && *finished == true;
}

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
    throw InputError(
        {found +
         ": contains a run of a track (alone or on a ground) without a checkpoint; such a run "
         "writes checkpoints only when it is stopped, or every output.checkpoint_interval or "
         "output.checkpoint_wall_interval: run the deck again"});
}

// A finished run may be made longer; the part after the checkpoint is then computed again.
bool is_track_left(const par::Comm& comm, const std::string& checkpoint, const model::Model& model,
                   const input::Deck& deck) {
  const io::File file = io::open_checkpoint(comm, checkpoint);
  const bool same = require_same_model(comm, file, checkpoint, model, deck);
  require_files(model.track);
  const bool reported = comm.root() && is_finished(fs::path(checkpoint).parent_path().string());
  return !same || comm.broadcast(reported ? "reported" : "").empty();
}

// They are read again when the model is built; they are small.
void require_files(const model::TrackModel& model) {
  for (const auto* one : {&model.irregularity, &model.irregularity_right})
    if (one->kind == track::IrregularityKind::file)
      track::Irregularity(*one, model.line.track.length);
  model::seats_of(model);
}

}  // namespace trackbed::app
