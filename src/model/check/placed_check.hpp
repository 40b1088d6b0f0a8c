// model = "stones": checks that need the shapes of the stones.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

struct World;

// For `check`: what is placed, windows of the stages, and wall time measured on some windows.
// Places and moves the stones. Collective.
std::vector<std::string> estimate_placed(World& world, const input::Deck& deck);

}  // namespace trackbed::model
