// Time steps of a stage, from the limits of the model that has been built.
#pragma once

#include <string>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/course.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

struct World;

// Longest stable sub-step of the stones, safety included.
struct StonesStep {
  double longest = 0;   // s
  std::string limit{};  // description of what limits it
};
StonesStep step_of(const World& world);  // of the existing stones; collective

// The same on any number of ranks. Throws InputError if the deck's window or step is above the
// stable one. Collective.
Steps choose_steps(const World& world, const StonesStep& stones, const Stage& stage,
                   const input::Deck& deck);

// Windows of a ground alone: as given in the deck, otherwise the ground's own steps.
Steps steps_alone(const World& world);

}  // namespace trackbed::model
