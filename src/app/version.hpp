// Which program this is.
#pragma once

#include <string>

#include "app/parameters.hpp"

namespace trackbed::app {

std::string version();
// The whole input with all defaults, as stored in every result. Without `start`: its state is in
// the results, the file may be gone.
std::string effective_deck(const Model& model);

}  // namespace trackbed::app
