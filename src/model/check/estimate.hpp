// Estimate of the cost of a deck before it runs: stones, windows, wall time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/scene/layer_stones.hpp"
#include "model/scene/world.hpp"
#include "model/stages/stages.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::model {

struct LayerForecast {
  std::string layer;      // name; empty: the uppermost one
  std::int64_t made = 0;  // stones that its stage of kind fill pours: exact
  std::int64_t left = 0;  // stones below the last profile and beside the sleepers: expected
  double step_time = 0;   // s of one core for a sub-step of a stone
};

// For each stage of kind fill, in order; copies of a cell are counted in `world`. `left` is correct
// as far as the compacted bed has the height and porosity given in the deck; stones of cribs are
// not included. Throws InputError if they cannot be made. Collective.
std::vector<LayerForecast> forecast(const World& world, const StonesOfLayers& stones);

struct Estimate {
  std::vector<std::string> lines;  // for `check`
  double step_time = 0;            // s of one core for a sub-step of a stone of the first layer
};
// `world` is filled by the first stage. Copies of a cell and the ground are moved, to measure them.
// Collective.
Estimate estimate(World& world, const StageActions& actions, const StonesOfLayers& stones,
                  const input::Deck& deck);
// The same of a ground alone, with the wall time of some windows. Moves the ground. Collective.
std::vector<std::string> estimate_alone(World& world);

}  // namespace trackbed::model
