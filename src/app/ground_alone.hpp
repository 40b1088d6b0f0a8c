// model = "ground": a ground without track and stones, under pressures of its own.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/limits.hpp"
#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

struct World;

// Its stages, ground and steps.
void declare_stages_alone(const Model& model, input::Section& s);
// Of other models that they have no pressures; of this one where they lie.
void declare_pressures(const Model& model, input::Section& s);
// Of a mesh, whose top only its file tells: adds what lies beside its box, m.
void require_below(const Model& model, const std::array<double, 2>& x,
                   const std::array<double, 2>& y, const input::Deck& deck,
                   std::vector<std::string>& problems);

// Windows as the deck gives them, else the ground's own steps.
Steps steps_alone(const World& world);
// Of `check`: what stages take, wall time from some windows. Moves the ground. Collective.
std::vector<std::string> estimate_alone(World& world);

}  // namespace trackbed::app
