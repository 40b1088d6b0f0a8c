// Checks whether time steps are short enough to resolve what wheels roll over.
#pragma once

#include <string>
#include <vector>

#include "trackbed/model/track_model.hpp"

namespace trackbed::model {

struct CoarseStep {
  std::string key;    // the parameter that the step does not resolve
  double value;       // m or s, of this parameter
  std::string words;  // the sentence that follows key and value
};

// What steps of `step` s do not resolve at the largest speed of the train: elements of the rail,
// profiles and flats; on a ground, whose step is not in the deck, also short forces on the rail.
std::vector<CoarseStep> coarse_steps(const TrackModel& model, double step);
// The same as warnings of the deck.
void declare_coarse_steps(const TrackModel& model, double step, input::Section& s);
// Sentences on a step that is known only when the track is built, including the interval of history
// rows (s).
std::vector<std::string> warnings_of_step(const TrackModel& model, double step,
                                          double history_interval);

}  // namespace trackbed::model
