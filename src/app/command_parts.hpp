// What several commands do on their way: they read a deck, look at the files it names, and end.
#pragma once

#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "app/rules.hpp"
#include "app/simulation.hpp"
#include "app/track_run.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Rank 0, on stdout.
void print(const par::Comm& comm, const std::string& text);

// Warnings before a run begins: said at once, and kept for its summary. All ranks have the same.
struct Warnings {
  const par::Comm& comm;
  std::vector<std::string> said = {};
  void add(const std::vector<std::string>& sentences);
};

input::Declaration declaration_of(Model& model);
// Warnings are said and the run goes on; problems leave as InputError.
// Collective; each rank parses alike and so has the same sentences.
Model read_model(const input::Deck& deck, Warnings& warnings);
// The file that a checkpoint's name or its folder's means; one that is passed over is worth a word.
// Collective.
std::string checkpoint_meant(const par::Comm& comm, const std::string& path,
                             io::IfDamaged if_damaged, Warnings& warnings);
// Throws InputError for what the ground's files cannot be. Collective.
GroundFile checked_ground(const Model& model, const input::Deck& deck, Warnings& warnings);
// Options that PETSc does not take are refused before anything is made or removed. A ground that
// never moves has no use for them. Returns the names of those that a run would not ask for, as far
// as that is known before it. Collective.
std::vector<std::string> try_options(const par::Comm& comm, const Model& model);
void warn_of_unused_options(const par::Comm& comm, const std::vector<std::string>& options);
// Of the rail of a train and of loads on a bed; a track alone has read them when it is built.
void look_at_profiles(const Model& model, Warnings& warnings);

// Both run, and give the exit code, which tells a script whether to run `resume`; a sentence tells
// a person. Collective.
int finish(const par::Comm& comm, Simulation& simulation, const std::string& folder);
int run_alone(const par::Comm& comm, const Model& model, const TrackRunOf& of);

}  // namespace trackbed::app
