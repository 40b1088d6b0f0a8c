// model = "stones": checks that need the shapes of the stones.
#pragma once

#include <string>
#include <vector>

#include "app/parameters/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

struct World;

struct StonesToPlace {
  std::vector<bed::PlacedShape> shapes;  // in the order of the deck; making them takes time
  std::vector<std::string> warnings;
};
// Throws InputError if a stone cannot be made, if stones initially overlap each other or a surface
// too deeply, or if the step of the deck is too long for them. Empty for other models. Collective.
StonesToPlace require_placed(const par::Comm& comm, const Model& model, const input::Deck& deck);
// For `check`: what is placed, windows of the stages, and wall time measured on some windows.
// Places and moves the stones. Collective.
std::vector<std::string> estimate_placed(World& world, const input::Deck& deck);

}  // namespace trackbed::app
