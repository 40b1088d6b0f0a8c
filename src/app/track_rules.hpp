// Rules of a track alone, and of the rail of a bed, that tie what is given to what it does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/track_model.hpp"

namespace trackbed::app {

// Zones without effect or that leave nothing to carry the rail, irregularities that no wheel meets
// or that are too fine, steps that are too long.
void declare_track_rules(const TrackModel& model, input::Section& s);
// A ballast mass stands on its own spring alone, which zones multiply; of the `count` sleepers from
// the `first` on, which stones bear, there is none. The track must be countable.
void declare_ballast_mass(const TrackModel& model, std::int64_t first, std::int64_t count,
                          input::Section& s);
// Where the track is as it is given: between its run-ins, m; of a bridge all of it.
Way between_run_ins(const track::TrackParameters& track);
// Parameters that another one leaves without effect.
void declare_idle(const TrackModel& model, input::Section& s);
// Sentences on what stands in files of irregularities; throws InputError for a bad one.
std::vector<std::string> doubts_of_files(const TrackModel& model);

}  // namespace trackbed::app
