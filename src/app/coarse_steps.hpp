// Whether steps in time are short enough for what wheels roll over.
#pragma once

#include <string>
#include <vector>

#include "app/track_model.hpp"

namespace trackbed::app {

struct CoarseStep {
  std::string key;    // the parameter that is at odds with the step
  double value;       // m or s, its own
  std::string words;  // what follows it
};

// What wheels jump over at their largest speed in steps of `step` s: elements of the rail, profiles
// and flats; on a ground, whose step the deck does not say, short forces on the rail.
std::vector<CoarseStep> coarse_steps(const TrackModel& model, double step);
// The same as warnings of the deck.
void declare_coarse_steps(const TrackModel& model, double step, input::Section& s);
// Of steps that are known only when the track is built: sentences, those on rows of the histories
// among them.
std::vector<std::string> doubts_of_step(const TrackModel& model, double step);

}  // namespace trackbed::app
