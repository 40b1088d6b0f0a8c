// Checks whether the results of a track's run are plausible: sentences for its warnings.
#pragma once

#include <string>
#include <vector>

#include "model/coupling/track_built.hpp"
#include "model/coupling/wheel_extremes.hpp"

namespace trackbed::model {

// Warnings of wheels off the rail, wheel forces and deflections of the rail (`lowest`, m, at each
// point of the deck) that are beyond those of any track. Local, the same on all ranks.
std::vector<std::string> warnings_of_passage(const TrackModel& model, const BuiltTrack& built,
                                             const WheelExtremes& wheels,
                                             const std::vector<double>& lowest);

}  // namespace trackbed::model
