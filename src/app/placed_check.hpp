// model = "stones": what only the shapes of the stones can tell.
#pragma once

#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

struct World;

struct StonesToPlace {
  std::vector<bed::PlacedShape> shapes;  // in the order of the deck; making them takes its time
  std::vector<std::string> warnings;
};
// Throws InputError if a stone cannot be made, stones begin within one another or within a surface,
// or the step of the deck is too long for them. Nothing of other models. Collective.
StonesToPlace require_placed(const par::Comm& comm, const Model& model, const input::Deck& deck);
// Of `check`: what is placed and what stages take, wall time from some windows. Places and moves
// the stones. Collective.
std::vector<std::string> estimate_placed(World& world, const input::Deck& deck);

}  // namespace trackbed::app
