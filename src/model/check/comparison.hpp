// What a comparison of transitions (docs/postproc.md) can judge of a model, stated before it runs.
#pragma once

#include <string>
#include <vector>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Of each block of the ground whether it is part of a structure; blocks that are not present are
// not.
std::vector<bool> structural_blocks(const fem::GroundParameters& ground);

// One line: the structure, where plain track begins at the earliest, and how many sleepers of both
// can be judged; empty for models without blocks in the ground or without a passage over sleepers.
std::string words_of_comparison(const Model& model);

}  // namespace trackbed::model
