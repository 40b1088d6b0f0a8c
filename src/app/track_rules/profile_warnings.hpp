// Checks whether a file of an irregularity is plausible: sentences for the warnings of a deck.
#pragma once

#include <string>
#include <vector>

#include "app/parameters/track_model.hpp"
#include "app/track_rules/strike.hpp"

namespace trackbed::app {

// For irregularities of kind file: heights in another unit, rows that end early, steps, jumps and
// changes of slope that wheels cannot follow. Cost: linear in the rows.
std::vector<std::string> warnings_of_profiles(const TrackModel& model, const Profiles& profiles);

}  // namespace trackbed::app
