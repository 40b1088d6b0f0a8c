// How stiff contacts can be: what time steps follow from.
#pragma once

#include "trackbed/dem/law.hpp"

namespace trackbed::dem {

// N/m, stiffness of the stiffest law. Hertz: k = F/delta on a contact of this radius (m) at the
// largest overlap allowed (share of the radius). Pairs of unknown materials do not count.
double stiffest_contact(const Physics& physics, double radius, double largest_overlap);

}  // namespace trackbed::dem
