// What a deck will ask of the machine, said before it runs: stones, windows, wall time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/limits.hpp"
#include "app/stages.hpp"
#include "app/world.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

struct LayerForecast {
  std::string layer;      // name; empty: the uppermost one
  std::int64_t made = 0;  // stones that its stage of kind fill pours: exact
  std::int64_t left = 0;  // of them below the last profile and beside the sleepers: expected
  double step_time = 0;   // s of one core for a sub-step of all that are made
};

// Of each stage of kind fill, in their order; copies of a cell are counted in `world`. `left` holds
// as far as the pressed bed has the height and porosity that the deck expects; stones of cribs are
// not counted. Throws InputError if they cannot be made. Collective.
std::vector<LayerForecast> forecast(const World& world, const StonesOfLayers& stones);

// Sentences for `check`. `world` is filled by the first stage. Collective.
std::vector<std::string> estimate(const World& world, const StageActions& actions,
                                  const StonesOfLayers& stones, const input::Deck& deck);

}  // namespace trackbed::app
