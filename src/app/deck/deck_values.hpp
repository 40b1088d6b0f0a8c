// What differs between two decks.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/values.hpp"

namespace trackbed::app {

using input::Values;
using input::values_of;

// "key = new (previously old)" for each value that differs, except the title, the duration of a
// passage, and those that set when to stop and when to write a checkpoint.
std::vector<std::string> changes(const Values& before, const Values& now);
// "key=new" for each of those exceptions that differs: overrides of a resume.
std::vector<std::string> changes_without_effect(const Values& before, const Values& now);

}  // namespace trackbed::app
