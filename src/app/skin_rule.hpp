// A warning about a skin of the neighbour lists that fits no stones.
#pragma once

#include "app/parameters.hpp"

namespace trackbed::app {

// Stones have diameters between these, m.
void declare_skin(const Model& model, double smallest, double largest, input::Section& s);
void declare_skin_of_bed(const Model& model, input::Section& s);

}  // namespace trackbed::app
