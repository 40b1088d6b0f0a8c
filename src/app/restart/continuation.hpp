// A run that a queue starts again: it continues if its folder holds the same run.
#pragma once

#include <string>
#include <vector>

#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Whether there is a valid checkpoint. Collective.
bool has_checkpoint(const par::Comm& comm, const std::string& folder);

// Throws InputError if `folder`, which has no checkpoint, has results of another run, or results
// that cannot be read; those of this run are to be replaced. Collective.
void require_of_same_run(const par::Comm& comm, const std::string& folder,
                         const model::Model& model);

// Overrides with which the run in `folder`, which has a checkpoint or is finished, is resumed as
// the run of `model`: what a resume may change without a word (limits of time, intervals of
// checkpoints). Throws InputError, with each difference, if it is a run of another input.
// Collective.
std::vector<std::string> overrides_of_same_run(const par::Comm& comm, const std::string& folder,
                                               const model::Model& model);

}  // namespace trackbed::app
