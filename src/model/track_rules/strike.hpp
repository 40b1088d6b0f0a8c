// Wheel force at a place where the profile causes an impact.
#pragma once

#include <cstddef>
#include <optional>

#include "trackbed/model/track_model.hpp"

namespace trackbed::model {

// Profiles of the rails: `right` if it differs from `left`.
struct Profiles {
  const track::Irregularity& left;
  const std::optional<track::Irregularity>& right;
};

double largest_speed(const track::TrainParameters& train);  // m/s
// s, the step of the deck, or a longer one: forces at jumps depend on it.
double step_of_strikes(const TrackModel& model);

// N, the largest force of the first wheel that rolls on this side, at the train's largest speed,
// while it passes x (m) on the track's springs. None without such a wheel, or if the track or the
// train cannot be computed. Local.
std::optional<double> strike_at(const TrackModel& model, const Profiles& profiles, std::size_t side,
                                double x);

}  // namespace trackbed::model
