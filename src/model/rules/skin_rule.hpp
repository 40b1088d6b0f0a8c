// A warning about a skin of the neighbour lists that does not fit the stones.
#pragma once

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// `smallest`, `largest`: diameters of stones, m.
void declare_skin(const Model& model, double smallest, double largest, input::Section& s);
void declare_skin_of_bed(const Model& model, input::Section& s);

}  // namespace trackbed::model
