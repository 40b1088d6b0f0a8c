// Which times and frequencies of a wave hold how much of its energy: that of its velocity, in one
// direction.
#pragma once

#include <vector>

#include "base_motion.hpp"

namespace trackbed::fem {

class WaveBand {
 public:
  // What the ground feels of a wave along x (0) or z (2): from 0 s on.
  WaveBand(const BaseMotion& wave, int axis);

  double energy() const;                    // m^2/s, of the velocity's square over time
  double energy_until(double time) const;   // likewise, up to `time` (s)
  double time_of(double share) const;       // s, until which this share of the energy has come
  double frequency_of(double share) const;  // Hz, below which this share of the energy lies

 private:
  double begin_, step_;           // s
  std::vector<double> velocity_;  // m/s, means over steps
};

}  // namespace trackbed::fem
