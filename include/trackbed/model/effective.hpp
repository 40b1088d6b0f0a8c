// Version of the program, and the effective input.
#pragma once

#include <string>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

std::string version();
// Commit, compiler and its options, versions of the libraries: one line, as in every result.
std::string build_description();
input::Declaration declaration_of(Model& model);
// The whole input with all defaults, as stored in every result.
std::string effective_deck(const Model& model);

}  // namespace trackbed::model
