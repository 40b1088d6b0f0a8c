// model = "stones": checks of the initial positions of stones, relative to each other and to plates
// and boxes.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

struct World;

// One sentence each, in the order of the deck.
struct PlacesOfStones {
  std::vector<std::string> problems, warnings;
};
// The stones must have been placed, with these shapes. Collective.
PlacesOfStones look_at_places(const World& world, const std::vector<bed::PlacedShape>& shapes,
                              const input::Deck& deck);

}  // namespace trackbed::model
