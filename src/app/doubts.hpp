// Whether what came out can be what was meant: sentences for the warnings of a run. A run that is
// in doubt goes on and ends with 0; to judge it is the user's.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/world.hpp"

namespace trackbed::app {

// On the height and porosity of the bed below a platen that has pressed it, against those of the
// layers that the stages `done` poured; empty: as asked. Collective.
std::string doubt_of_bed(const World& world, std::span<const Stage> done);
// On sleepers that sank and stones that fly at the end of a run whose last stage was of this kind.
// Collective.
std::vector<std::string> doubts_of_end(const World& world, StageKind last);

}  // namespace trackbed::app
