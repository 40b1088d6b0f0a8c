// Version of the program, and the effective input.
#pragma once

#include <string>

#include "app/parameters/parameters.hpp"

namespace trackbed::app {

std::string version();
// The whole input with all defaults, as stored in every result.
std::string effective_deck(const Model& model);

}  // namespace trackbed::app
