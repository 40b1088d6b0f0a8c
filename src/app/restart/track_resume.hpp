// Which runs of a track, alone or on a ground, can be resumed, and with which changes of their
// input.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Reads the files the deck names, so that a bad one is refused before anything is changed. Local;
// throws InputError.
void require_files(const model::TrackModel& model);
// Throws InputError if `path` is, or is in, the result folder of a track, alone or on a ground,
// without a checkpoint. Collective.
void require_track_checkpoint(const par::Comm& comm, const std::string& path);
// Whether the summary in the result folder is that of a finished run; on rank 0.
bool is_finished(const std::string& folder);
// Whether the run that wrote `checkpoint` is unfinished, or is continued with another deck. Throws
// InputError as `require_same_model`, and for bad files. Collective.
bool is_track_left(const par::Comm& comm, const std::string& checkpoint, const model::Model& model,
                   const input::Deck& deck);

}  // namespace trackbed::app
