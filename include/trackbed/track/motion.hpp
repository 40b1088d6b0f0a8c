// Prescribed motion of a train along the track: position of its first axle over time. Braking
// forces are not computed, and the effects of longitudinal inertia on vehicles (pitch, load
// transfer to the front) are not modelled.
#pragma once

#include <vector>

#include "trackbed/track/train.hpp"

namespace trackbed::track {

class Motion {
 public:
  explicit Motion(const TrainParameters& parameters);
  double x(double time) const;      // m, of the first axle; s since the train started, at least 0
  double speed(double time) const;  // m/s
  double time_at(double x) const;   // s, when the first axle reaches x; infinite if it stops before

 private:
  // Constant acceleration from `begin` on; the last leg has no end: s, m, m/s, m/s^2.
  struct Leg {
    double begin, x, speed, acceleration;
  };
  const Leg& leg_at(double time) const;
  std::vector<Leg> legs_;
};

}  // namespace trackbed::track
