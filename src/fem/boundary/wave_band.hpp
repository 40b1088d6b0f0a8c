// Distribution of the energy of a wave over time and frequency: energy of its velocity, in one
// direction.
#pragma once

#include <vector>

#include "fem/time/base_motion.hpp"

namespace trackbed::fem {

class WaveBand {
 public:
  // The part of a wave along x (0) or z (2) that acts on the ground: from 0 s on.
  WaveBand(const BaseMotion& wave, int axis);

  double energy() const;                   // m^2/s, time integral of the squared velocity
  double energy_until(double time) const;  // the same, up to `time` (s)
  double time_of(double fraction) const;   // s, by which this fraction of the energy has arrived
  double frequency_of(double fraction) const;  // Hz, below which this fraction of the energy is

 private:
  double begin_, step_;           // s
  std::vector<double> velocity_;  // m/s, means over steps
};

}  // namespace trackbed::fem
