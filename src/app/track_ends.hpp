// Whether what came out of a track's run can be what was meant: sentences for its warnings.
#pragma once

#include <string>
#include <vector>

#include "app/track_built.hpp"
#include "app/wheel_extremes.hpp"

namespace trackbed::app {

// On wheels off the rail, forces of wheels and deflections of the rail (`lowest`, m, at each point
// of the deck) that no track has. Local, the same on all ranks.
std::vector<std::string> doubts_of_passage(const TrackModel& model, const Built& built,
                                           const WheelExtremes& wheels,
                                           const std::vector<double>& lowest);

}  // namespace trackbed::app
