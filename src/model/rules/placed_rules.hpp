// model = "stones": rules of decks that place stones one by one.
#pragma once

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Other models must have none of its tables.
void declare_no_placed(const PlacedParameters& placed, input::Section& s);
// The domain of the deck; otherwise a box around all that is placed, with a margin for the travel
// of the stones.
dem::Domain domain_of_placed(const Model& model);

}  // namespace trackbed::model
