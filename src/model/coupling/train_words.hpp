// What is printed of a train before it runs, to check that it is the intended one.
#pragma once

#include <string>
#include <vector>

#include "trackbed/track/train.hpp"

namespace trackbed::model {

// One line for each kind of vehicle; `rolls`: on two rails.
std::vector<std::string> lines_of_vehicles(const track::Train& train, bool rolls);

}  // namespace trackbed::model
