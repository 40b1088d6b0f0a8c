// model = "ground": a ground without track and stones, loaded by pressures given in the deck.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Rules of its stages, ground and steps.
void declare_stages_alone(const Model& model, input::Section& s);
// Rules of pressures: their position in this model; other models must have none.
void declare_pressures(const Model& model, input::Section& s);
// For a mesh, whose top is known only from its file: adds pressures outside of its bounding box, m.
void require_below(const Model& model, const std::array<double, 2>& x,
                   const std::array<double, 2>& y, const input::Deck& deck,
                   std::vector<std::string>& problems);

}  // namespace trackbed::model
