// Yield check by Mohr-Coulomb's cones, for eight elements at once.
#pragma once

#include "fem/material/mohr_coulomb.hpp"
#include "fem/shape/lanes.hpp"

namespace trackbed::fem {

// Minimum over the points of the margin to the cones, per lane; below 0: perhaps beyond the yield
// surface. Units are mixed, only the sign is used. `Cone`: as MohrCoulomb::Cone, of one solid or of
// one in each lane.
template <int components, int points, class Cone>
Lane yield_margin(const Lane (&value)[components][points], const std::array<Cone, 2>& cones) {
  Lane least = Lane{} + 1.0;
  for (int g = 0; g < points; ++g) {
    const Lane x = value[0][g], y = value[1][g], z = value[2][g];
    const Lane mean = (x + y + z) * (1.0 / 3);
    const Lane xy = x - y, yz = y - z, zx = z - x;
    Lane second = (xy * xy + yz * yz + zx * zx) * (1.0 / 6);
    for (int c = 3; c < components; ++c) second += value[c][g] * value[c][g];
    for (const Cone& cone : cones) {
      const Lane left = cone.limit - cone.slope * mean;
      const Lane square = left * left - cone.factor * second;
      least = left < least ? left : least;
      least = square < least ? square : least;
    }
  }
  return least;
}

}  // namespace trackbed::fem
