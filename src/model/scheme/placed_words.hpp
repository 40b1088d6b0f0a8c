// model = "stones": error messages with the names of the deck.
#pragma once

#include <string>

namespace trackbed::model {

struct World;

// Replaces the numbers used by the module dem: "particle 2 left the domain" becomes "stone \"top\"
// left the domain", and overlapping stones are named. Local, on the rank with the problem.
std::string by_names(const std::string& problem, const World& world);

}  // namespace trackbed::model
