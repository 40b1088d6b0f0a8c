// Runs of a track alone: seconds, so neither stages nor checkpoints.
#pragma once

#include <string>

#include "app/track_model.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// What a run needs besides its model.
struct TrackRunOf {
  std::string deck, effective, folder;  // name, effective input, result folder
};

// Reads the files the deck names, so that a bad one is refused before anything is touched. Local;
// throws InputError.
void require_files(const TrackModel& model);
// The folder is there and held. Collective; throws InputError, RunError.
void run_track(const par::Comm& comm, const TrackModel& model, const TrackRunOf& run);
// Says what the model is made of and, from some steps, how long a run takes. Collective.
void check_track(const par::Comm& comm, const TrackModel& model);
// Throws InputError if `path` is, or lies in, the result folder of a track alone. Collective.
void refuse_to_resume_track(const par::Comm& comm, const std::string& path);

}  // namespace trackbed::app
