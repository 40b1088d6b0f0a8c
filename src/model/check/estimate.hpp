// Estimate of the cost of a deck before it runs: stones, windows, wall time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/check/forecast.hpp"
#include "model/stages/stages.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::model {

struct Estimate {
  std::vector<std::string> lines;  // for `check`
  double step_time = 0;            // s of one core for a sub-step of a stone of the first layer
  std::string problem;             // why the first windows fail, or nothing
};
// `world` is filled by the first stage. Copies of a cell and the ground are moved, to measure them.
// Collective.
Estimate estimate(World& world, const StageActions& actions, const StonesOfLayers& stones,
                  const input::Deck& deck);
// The same of a ground alone, with the wall time of some windows. Moves the ground. Collective.
std::vector<std::string> estimate_alone(World& world);

}  // namespace trackbed::model
