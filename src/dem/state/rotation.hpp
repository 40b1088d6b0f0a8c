// Free rotation of bodies with three moments of inertia, in space. Spheres and plane models do not
// need it (step.cpp).
#pragma once

#include "dem/state/state.hpp"

namespace trackbed::dem {

// Spin I^-1 L in space axes, rad/s, of an attitude, an angular momentum and principal moments.
// The formula of `drift_and_rotate`, so that a rebuild does not change results.
Vec4 spin_of(const Vec4& attitude, const Vec4& momentum, const Vec4& inertia);

// Moves centres and attitudes of own particles by dt at constant v and L, and computes their spins.
// Returns the largest displacement of a surface point since the poses given, m: the distance of the
// centres and the arc of the point that is farthest from the axis.
double drift_and_rotate(State& state, double dt, const std::vector<Vec4>& reference_x,
                        const std::vector<Vec4>& reference_q);

}  // namespace trackbed::dem
