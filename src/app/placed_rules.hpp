// model = "stones": what a deck that places stones one by one may say.
#pragma once

#include "app/parameters.hpp"

namespace trackbed::app {

// Of other models: that they have none of its tables.
void declare_no_placed(const PlacedParameters& placed, input::Section& s);
// The box of the deck; else around all that is placed, with room for the ways that stones may go.
dem::Domain domain_of_placed(const Model& model);

}  // namespace trackbed::app
