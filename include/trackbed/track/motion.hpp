// How a train goes along the track: where its first axle is at any time. Given beforehand: braking
// needs no force here, and what inertia along the track does to vehicles (pitch, load that moves to
// the front) is not modelled.
#pragma once

#include <vector>

#include "trackbed/track/train.hpp"

namespace trackbed::track {

class Motion {
 public:
  explicit Motion(const TrainParameters& parameters);
  double x(double time) const;      // m, of the first axle; s since the train was sent, at least 0
  double speed(double time) const;  // m/s
  double time_at(double x) const;   // s until the first axle is there; infinite if it stops before

 private:
  // From `begin` on, the last one for ever: s, m, m/s, m/s^2.
  struct Leg {
    double begin, x, speed, acceleration;
  };
  const Leg& leg_at(double time) const;
  std::vector<Leg> legs_;
};

}  // namespace trackbed::track
