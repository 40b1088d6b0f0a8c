// What a run would cost on many ranks, from partitions of its stones made on one.
#pragma once

#include <string>
#include <vector>

#include "model/scene/world.hpp"

namespace trackbed::model {

// A table: work, ghosts and messages of a sub-step for each number of ranks, and the speed-up with
// a usual network. The stones must be in place, on one rank.
std::vector<std::string> scaling_of(World& world, const std::vector<int>& ranks);

}  // namespace trackbed::model
