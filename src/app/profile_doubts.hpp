// Whether a file of an irregularity can be meant: sentences for the warnings of a deck.
#pragma once

#include <string>
#include <vector>

#include "app/track_model.hpp"

namespace trackbed::app {

// Of a profile of kind file: heights in another unit, rows that end early, steps, jumps and changes
// of slope that wheels cannot be meant to follow. Linear in the rows.
std::vector<std::string> doubts_of_profile(const TrackModel& model,
                                           const track::Irregularity& profile,
                                           const track::IrregularityParameters& parameters);

}  // namespace trackbed::app
