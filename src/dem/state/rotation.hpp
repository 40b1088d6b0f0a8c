// Free rotation of bodies with three moments of inertia, in space or in a plane. Spheres do not
// need it (step.cpp).
#pragma once

#include "dem/lanes/lanes.hpp"
#include "dem/state/state.hpp"

namespace trackbed::dem {

// Spin I^-1 L in space axes, rad/s, of an attitude, an angular momentum and principal moments.
// The formula of `drift_and_rotate`, so that a rebuild does not change results.
Vec4 spin_of(const Vec4& attitude, const Vec4& momentum, const Vec4& inertia);

// A force f on particle b with the torque f T about its centre of mass turns it as well: the
// velocity at which the force does work grows by f (1/m + T . I^-1 T) per second. This is the
// second term, 1/kg, for a lever T (m); 0 for a held particle, whose spin no torque changes. At
// most `largest_inverse_moment` T^2.
double inverse_mass_of_turning(const State& state, std::size_t b, const Triple<double>& lever);
// One over the least principal moment, 1/(kg m2); 0 for a held particle.
double largest_inverse_moment(const State& state, std::size_t b);

// Poses of own particles since which displacements are measured; `slow`: 1 for those whose speed is
// measured, or 0; null: for none.
struct Reference {
  const std::vector<Vec4>&x, &q;
  const double* slow = nullptr;
};
// Of any surface point: the distance of the centres and the arc of the point that is farthest from
// the axis, m; and the speed of those that are slow, m/s.
struct LargestMotion {
  double displacement = 0, slow_speed = 0;
};
// Moves centres and attitudes of own particles by dt at constant v and L, and computes their spins.
// In a plane they rotate about y.
LargestMotion drift_and_rotate(State& state, Dimension dimension, double dt,
                               const Reference& since);

}  // namespace trackbed::dem
