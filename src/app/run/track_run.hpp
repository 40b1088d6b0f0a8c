// Runs of a track alone, or on a ground: no stages; checkpoints at an interval of the deck, or when
// a run is stopped.
#pragma once

#include <string>
#include <vector>

#include "app/parameters/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Input of a run besides its model.
struct TrackRunInput {
  std::string deck, effective, folder;     // name, effective input, result folder
  std::string checkpoint = "";             // to continue from; empty: from the start
  std::vector<std::string> warnings = {};  // earlier warnings of the deck
};

// The folder must exist and be locked. Returns whether the run finished; otherwise it was stopped,
// with a checkpoint. Collective; throws InputError, RunError.
bool run_track(const par::Comm& comm, const Model& model, const TrackRunInput& run);
// Prints the properties of the model and an estimate of the wall time from some steps. Collective.
void check_track(const par::Comm& comm, const Model& model);

}  // namespace trackbed::app
