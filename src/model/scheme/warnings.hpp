// Checks whether results are plausible: sentences for the warnings of a run. A run with warnings
// continues and its exit code is 0; the user must judge it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "model/scene/world.hpp"
#include "trackbed/model/course.hpp"

namespace trackbed::model {

// On height and porosity of the compacted bed, compared with those of the layers that the stages
// `done` poured; empty: as expected. Collective.
std::string warning_of_bed(const World& world, std::span<const Stage> done);
// On sub-steps that the contacts at the end of their stage do not allow; empty: there are none.
std::string warning_of_steps(const Model& model, std::span<const StageRecord> done);
// On the elastic energy of contacts that become stiffer when `next` follows `stage`, at the end of
// which they are now; empty: it moves no stone noticeably. Collective; needs lists.
std::string warning_of_stiffening(const World& world, const Stage& stage, const Stage& next);
// On bonds that should have been made before the first stage of this run. Collective.
std::vector<std::string> warnings_of_bonds(const World& world, std::size_t stage);
// On settled sleepers and fast stones at the end of a run whose last stage was of this kind.
// Collective.
std::vector<std::string> warnings_of_end(const World& world, StageKind last);

}  // namespace trackbed::model
