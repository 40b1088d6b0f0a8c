// Speeds are linear between the given times, so that x is a parabola in each leg and is integrated
// exactly, without a sum over steps that would depend on their length or drift,
//   x(t) = x_i + v_i (t - t_i) + a_i (t - t_i)^2/2,   a_i = (v_i+1 - v_i)/(t_i+1 - t_i)   m, s.
// Rejected: x integrated with the steps of the passage, which would be part of checkpoints;
// discontinuous speeds, which are unphysical.
#include "trackbed/track/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

Motion::Motion(const TrainParameters& parameters)
    : legs_{{0, parameters.start, parameters.speed, 0}} {
  require(parameters.changes_are_valid(),
          "times of a train must increase from above 0, with one speed for each");
  for (std::size_t i = 0; i < parameters.times.size(); ++i) {
    Leg& leg = legs_.back();
    const double lasts = parameters.times[i] - leg.begin, reached = parameters.speeds[i];
    leg.acceleration = (reached - leg.speed) / lasts;
    legs_.push_back({parameters.times[i], leg.x + (leg.speed + reached) / 2 * lasts, reached, 0});
  }
}

const Motion::Leg& Motion::leg_at(double time) const {
  const auto after = std::upper_bound(legs_.begin() + 1, legs_.end(), time,
                                      [](double t, const Leg& leg) { return t < leg.begin; });
  return *(after - 1);
}

double Motion::x(double time) const {
  const Leg& leg = leg_at(time);
  const double since = time - leg.begin;
  return leg.x + (leg.speed + leg.acceleration / 2 * since) * since;
}

double Motion::speed(double time) const {
  const Leg& leg = leg_at(time);
  return leg.speed + leg.acceleration * (time - leg.begin);
}

// x is reached in the last leg that begins before x, since no train runs backwards. The root of the
// parabola is in the form that is accurate for a small acceleration.
double Motion::time_at(double x) const {
  if (x <= legs_.front().x) return 0;
  const auto after = std::lower_bound(legs_.begin() + 1, legs_.end(), x,
                                      [](const Leg& leg, double place) { return leg.x < place; });
  const Leg& leg = *(after - 1);
  const double travel = x - leg.x;
  const double square = leg.speed * leg.speed + 2 * leg.acceleration * travel;
  const double speeds = leg.speed + std::sqrt(std::max(square, 0.0));
  return speeds > 0 ? leg.begin + 2 * travel / speeds : std::numeric_limits<double>::infinity();
}

}  // namespace trackbed::track
