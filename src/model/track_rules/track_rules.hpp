// Rules of a track alone, and of the rail of a bed, on the effect of parameters.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/model/track_model.hpp"

namespace trackbed::model {

// Zones without effect or that leave the rail without support, irregularities that no wheel passes
// or that are too fine, steps that are too long.
void declare_track_rules(const TrackModel& model, input::Section& s);
// A ballast mass is supported only by its own spring, which zones multiply. The `count` sleepers
// from number `first` on are supported by stones and have none. The track must be countable.
void declare_ballast_mass(const TrackModel& model, std::int64_t first, std::int64_t count,
                          input::Section& s);
// Part of the track with the given stiffness, between its run-ins, m; the whole track of a bridge.
Range between_run_ins(const track::TrackParameters& track);
// Parameters without effect because of another one.
void declare_idle(const TrackModel& model, input::Section& s);
}  // namespace trackbed::model
