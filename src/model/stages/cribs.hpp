// Stones between sleepers.
#pragma once

#include <vector>

#include "model/scene/world.hpp"

namespace trackbed::model {

// Boxes of the bed between the sleepers (in space also beside their ends), from their lower faces
// up to z = `top`. The sleepers must be placed. The same on all ranks.
std::vector<bed::Box> cribs(World& world, double top);
// Removes stones that overlap a sleeper. Collective.
void dig_out_sleepers(World& world);
// Removes stones with their centre above the outline of the bed whose crest is at z = `crest`.
// Collective.
void cut_to_profile(World& world, double crest);

}  // namespace trackbed::model
