// The places of stones between sleepers.
#pragma once

#include <vector>

#include "app/world.hpp"

namespace trackbed::app {

// What is left of the bed between the sleepers (space: and beside their ends), from their lower
// faces up to z = `top`. The sleepers are placed.
// Same on all ranks: sleepers are.
std::vector<bed::Box> cribs(World& world, double top);
// Takes away stones that a sleeper overlaps. Collective.
void dig_out_sleepers(World& world);
// Takes away stones with their centre above the outline of the bed whose crest is at z = `crest`.
// Collective.
void cut_to_profile(World& world, double crest);

}  // namespace trackbed::app
