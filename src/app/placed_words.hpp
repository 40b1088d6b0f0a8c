// model = "stones": sentences of a run by the names of the deck.
#pragma once

#include <string>

namespace trackbed::app {

struct World;

// The room of the particles knows numbers: "particle 2 left the domain" becomes "stone \"top\" left
// the domain", and what overlaps is named. Local, on the rank that has the problem.
std::string by_names(const std::string& problem, const World& world);

}  // namespace trackbed::app
