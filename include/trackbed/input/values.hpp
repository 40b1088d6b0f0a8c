// The effective text of a deck as keys and values, to compare two decks.
#pragma once

#include <map>
#include <string>

namespace trackbed::input {

using Values = std::map<std::string, std::string>;  // ground.layer[0].young -> 1.5e+08

// `effective`: as `input::effective` writes it. "ground.layer" becomes "ground.layer[1]" if it is
// the second such table. Equal values have equal texts (numbers have 17 digits).
// Local, on a text that all ranks have.
Values values_of(const std::string& effective);

}  // namespace trackbed::input
