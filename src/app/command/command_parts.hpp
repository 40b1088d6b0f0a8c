// Parts that several commands share: reading a deck, checking the files it names, and ending.
#pragma once

#include <string>
#include <vector>

#include "app/run/run.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/model/log.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

using model::print;

// Warnings before a run begins: printed at once, and kept for its summary. The same on all ranks.
struct Warnings {
  const par::Comm& comm;
  std::vector<std::string> sentences = {};
  void add(const std::vector<std::string>& more);
};

// Warnings are printed; problems are raised as InputError. Collective; all ranks parse the same
// text and have the same sentences.
model::Model read_model(const input::Deck& deck, Warnings& warnings);
// The checkpoint meant by a file name or a folder; a warning names each damaged one that is passed
// over. Collective.
std::string checkpoint_meant(const par::Comm& comm, const std::string& path,
                             io::IfDamaged if_damaged, Warnings& warnings);
// Throws InputError for bad files of the ground. Collective.
model::GroundFile checked_ground(const model::Model& model, const input::Deck& deck,
                                 Warnings& warnings);
// Options that PETSc does not accept are refused before anything is made or removed. A ground that
// never moves does not use them. Returns the names of those that a run would not use, as far as
// this is known before it. Collective.
std::vector<std::string> try_options(const par::Comm& comm, const model::Model& model);
void warn_of_unused_options(const par::Comm& comm, const std::vector<std::string>& options);
// Checks profiles of the rail of a train and loads on a bed; a track alone checks them when it is
// built.
void look_at_profiles(const model::Model& model, Warnings& warnings);

// Whether a path exists, by the file system of rank 0. Collective.
bool is_there(const par::Comm& comm, const std::string& path);
// Whether the summary in `folder` is that of a finished run. Collective.
bool is_finished_in(const par::Comm& comm, const std::string& folder);
// Whether a run in `folder` can be continued or is finished. Throws InputError if a run does not
// end that writes there. Collective.
bool has_begun(const par::Comm& comm, const std::string& folder);

// Runs and returns the exit code, from which a script decides whether to run `resume`; a log line
// states the same. Collective.
int finish(Run& run, const model::RunContext& context);

}  // namespace trackbed::app
