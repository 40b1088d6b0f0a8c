// What a run would cost on many ranks, from partitions of its stones made on one.
#pragma once

#include <string>
#include <vector>

#include "model/scene/world.hpp"

namespace trackbed::model {

// A table: work, ghosts and messages of a sub-step for each number of ranks, and the speed-up with
// a usual network. `step_time`: s, estimated for a stone in a sub-step on one core. The stones must
// be in place, on one rank. Throws InputError if there are more ranks than stones.
std::vector<std::string> scaling_of(World& world, const std::vector<int>& ranks, double step_time);

}  // namespace trackbed::model
