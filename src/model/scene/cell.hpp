// A bed made of copies of one periodic cell: which checkpoint can be the cell, and how a stage of
// kind fill lays the copies.
#pragma once

#include "model/scene/world.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Throws InputError with all reasons why `bed.cell` cannot be repeated in this deck. Collective.
void require_cell(const par::Comm& comm, const Model& model, const input::Deck& deck);

// Fills the length of the bed with copies of the cell; there must be no stones yet. Stones that
// reach beyond end walls are removed. Returns the height of the highest stone, m. Collective.
double lay_cells(World& world);

}  // namespace trackbed::model
