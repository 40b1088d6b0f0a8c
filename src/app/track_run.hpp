// Runs of a track alone, or on a ground: no stages; checkpoints if asked for, or when a run is
// stopped.
#pragma once

#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// What a run needs besides its model.
struct TrackRunOf {
  std::string deck, effective, folder;     // name, effective input, result folder
  std::string checkpoint = "";             // to go on from; empty: from the begin
  std::vector<std::string> warnings = {};  // said of the deck before
};

// Reads the files the deck names, so that a bad one is refused before anything is touched. Local;
// throws InputError.
void require_files(const TrackModel& model);
// The folder is there and held. Whether the run came to its end; else it was stopped, with a
// checkpoint. Collective; throws InputError, RunError.
bool run_track(const par::Comm& comm, const Model& model, const TrackRunOf& run);
// Says what the model is made of and, from some steps, how long a run takes. Collective.
void check_track(const par::Comm& comm, const Model& model);

// Throws InputError if `path` is, or lies in, the result folder of a track alone that holds no
// checkpoint. Collective.
void require_track_checkpoint(const par::Comm& comm, const std::string& path);
// Whether the run that wrote `checkpoint` has something left to do. Throws InputError with all
// parameters in which its deck and `effective` differ, except those a run may go on with, and for
// bad files. Collective.
bool is_track_left(const par::Comm& comm, const std::string& checkpoint, const TrackModel& model,
                   const std::string& effective, const input::Deck& deck);
// A sentence for each parameter that this resume, and those before it, changed amid the run, but
// for those that say when to stop and to write. Collective.
std::vector<std::string> changed_on_resumes(const par::Comm& comm, const io::File& checkpoint,
                                            const std::string& effective);

}  // namespace trackbed::app
