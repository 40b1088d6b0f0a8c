// Whether a file of an irregularity can be meant: sentences for the warnings of a deck.
#pragma once

#include <string>
#include <vector>

#include "app/strike.hpp"
#include "app/track_model.hpp"

namespace trackbed::app {

// Of those of kind file: heights in another unit, rows that end early, steps, jumps and changes of
// slope that wheels cannot be meant to follow. Linear in the rows.
std::vector<std::string> doubts_of_profiles(const TrackModel& model, const Profiles& profiles);

}  // namespace trackbed::app
