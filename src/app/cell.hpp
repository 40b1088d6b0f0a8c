// A bed that is repeated from one periodic cell: which checkpoint may be its cell, and the stage
// fill that lays its copies.
#pragma once

#include "app/parameters.hpp"
#include "app/world.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

// Throws InputError with all reasons why `bed.cell` cannot be repeated in this deck. Collective.
void require_cell(const par::Comm& comm, const Model& model, const input::Deck& deck);

// As many copies of the cell as the bed is long, in a world without stones. At ends that are walls
// stones that reach beyond them are taken away. Returns the height of the highest stone, m.
// Collective.
double lay_cells(World& world);

}  // namespace trackbed::app
