// Checks whether a file of an irregularity is plausible: sentences for the warnings of a deck.
#pragma once

#include <string>
#include <vector>

#include "model/track_rules/strike.hpp"
#include "trackbed/model/track_model.hpp"

namespace trackbed::model {

// For irregularities of kind file: heights in another unit, rows that end early, steps, jumps and
// changes of slope that wheels cannot follow. Cost: linear in the rows.
std::vector<std::string> warnings_of_profiles(const TrackModel& model, const Profiles& profiles);

}  // namespace trackbed::model
