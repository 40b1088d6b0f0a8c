// Half kicks of one particle, v += dt/2 F/m and L += dt/2 T, on rows of four numbers. The fourth
// number of a row stores another quantity (mass, radius) and is unchanged.
#pragma once

#include "dem/lanes/rows.hpp"
#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

// Cundall's local damping: a fraction of the net force resists the motion,
//   F = F - alpha |F| sign(v), for each component (Cundall 1987).
// It does not depend on frequency and removes nothing from steady motion without net force. It
// depends on the axes; for rotation the sign is that of the angular momentum, not of the spin: the
// same for spheres, and for stones no attitude is needed.
[[gnu::always_inline]] inline Four damped(Four force, Four velocity, double alpha) {
  const Four part = alpha * (force < 0 ? -force : force);
  return force - (velocity > 0 ? part : velocity < 0 ? -part : Four{});
}

class Kick {
 public:
  // `gravity` (m/s^2) acts along -z. In a plane model, forces in the fixed degrees of freedom are
  // carried by the plane.
  Kick(double dt, double gravity, Dimension dimension)
      : half_(0.5 * dt),
        weight_{0, 0, -gravity, 0},
        moves_(dimension == Dimension::plane ? Four{1, 0, 1, 0} : Four{1, 1, 1, 0}),
        turns_(dimension == Dimension::plane ? Four{0, 1, 0, 0} : Four{1, 1, 1, 0}) {}

  // `halves` half kicks by the same force and torque: one closes a sub-step or begins the first of
  // a window, two do both for all others, bitwise identical to two passes. alpha: local damping,
  // which uses the velocity before each half.
  [[gnu::always_inline]] void operator()(Four& v, Four& l, Four force, Four torque, int halves,
                                         double alpha) const {
    const double mass = v[3];
    const Four f = force + mass * weight_;
    const Four over_mass = (half_ / mass) * moves_, over_one = half_ * turns_;
    for (int k = 0; k < halves; ++k) {
      v = v + over_mass * (alpha > 0 ? damped(f, v, alpha) : f);
      l = l + over_one * (alpha > 0 ? damped(torque, l, alpha) : torque);
    }
  }

 private:
  double half_;
  Four weight_;         // m/s^2
  Four moves_, turns_;  // 1 for each degree of freedom
};

}  // namespace trackbed::dem
