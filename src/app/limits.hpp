// How long a time step may be. Rough limits need only the deck, the exact one asks the model.
#pragma once

#include <map>
#include <string>

#include "app/parameters.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

struct World;

// Estimate of the stable sub-step, s: safety * sqrt(m/k) of a stone of the smallest sieve. Without
// the stones' shapes known to within a factor of 1.5.
// A contact of mass m and stiffness k is an oscillator that central differences follow up to 2
// sqrt(m/k); several contacts at once and rotation take most of the 2, the safety factor the rest.
double rough_step_limit(const Model& model);

// What the largest window of the staggered coupling follows from: 0.5 sqrt(m/(n k)) of the body for
// which it is shortest (sleeper; node of the ground's top, if it moves) on n contacts of the
// largest stiffness k. The load of a window acts one window late, which feeds energy into an
// oscillator of frequency w at the rate w^2 dt/2; at this limit the damping of the contacts still
// takes more.
struct CouplingLimit {
  double window;       // s, infinite if nothing moves
  std::string body{};  // "sleeper of 202 kg"
  // n, at once. Sleeper: stones of the smallest sieve side by side on its face.
  double contacts = 1;
  double stiffness = 0;   // k, N/m
  std::string instead{};  // of the words on body and contacts
  std::string words() const;
};
CouplingLimit coupling_limit(const Model& model, bool ground_moves);
// Of a stage; its train asks for windows of `passage.step` at most, and for a quarter of what is
// stable for rigid sleepers on the pads of the rail.
CouplingLimit coupling_limit(const Model& model, const Stage& stage);

// A window is `substeps` sub-steps of equal length, each at most the stable one.
struct Steps {
  double window = 0;  // s
  int substeps = 1;
  std::string limit;  // what limits them, in words
};

// Of each layer that stages make, by its name, before any stone is there.
using StonesOfLayers = std::map<std::string, bed::Stones>;

// Throws InputError if the stones that the deck asks for cannot be made, or not be moved with its
// step: known from the deck alone, so that a run is refused before it leaves anything behind.
// Returns what they will be, since placing them takes its time. Collective.
StonesOfLayers require_stones(const par::Comm& comm, const Model& model, const input::Deck& deck);

// Sentences about layers whose stones are much longer than the sieves they pass.
std::vector<std::string> warnings_of(const Model& model, const StonesOfLayers& layers);

// Longest stable sub-step of the stones, safety included.
struct StonesStep {
  double longest = 0;   // s
  std::string limit{};  // what limits it, in words
};
StonesStep step_of(const Model& model, const StonesOfLayers& layers);  // of all of them together
StonesStep step_of(const World& world);  // of the stones there are; collective

// Throws InputError if the deck's sub-step is above `limit`, s, which `words` explain.
void require_stable(const Model& model, const input::Deck& deck, double limit,
                    const std::string& words);

// Equal on any number of ranks. Throws InputError if the deck's window or step is above what is
// stable. Collective.
Steps choose_steps(const World& world, const StonesStep& stones, const Stage& stage,
                   const input::Deck& deck);

}  // namespace trackbed::app
