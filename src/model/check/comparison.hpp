// What a comparison of transitions (docs/postproc.md) can judge of a model, stated before it runs.
#pragma once

#include <string>
#include <vector>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// For each block of the ground: is it part of a structure? False for blocks that are not present.
std::vector<bool> structural_blocks(const fem::GroundParameters& ground);

// One line: the structure, where plain track begins at the earliest, and how many sleepers of both
// can be judged; empty for models without blocks in the ground or without a passage over sleepers.
std::string words_of_comparison(const Model& model);

}  // namespace trackbed::model
