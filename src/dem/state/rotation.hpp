// Free rotation of bodies with three moments of inertia, in space. Spheres and plane models do not
// need it (step.cpp).
#pragma once

#include "dem/lanes/lanes.hpp"
#include "dem/state/state.hpp"

namespace trackbed::dem {

// v turned by the unit quaternion (u, w): v + 2 w u x v + 2 u x (u x v).
template <class Real>
[[gnu::always_inline]] inline Triple<Real> turned(const Triple<Real>& u, Real w,
                                                  const Triple<Real>& v) {
  Triple<Real> uv = cross(u, v);
  uv = {uv.x + uv.x, uv.y + uv.y, uv.z + uv.z};
  const Triple<Real> uuv = cross(u, uv);
  return {v.x + w * uv.x + uuv.x, v.y + w * uv.y + uuv.y, v.z + w * uv.z + uuv.z};
}

// From space to principal axes: by the conjugate.
template <class Real>
[[gnu::always_inline]] inline Triple<Real> to_body(const Real (&q)[4], const Triple<Real>& v) {
  return turned(Triple<Real>{-q[0], -q[1], -q[2]}, q[3], v);
}

// Spin I^-1 L in space axes, rad/s, of an attitude, an angular momentum and principal moments.
// The formula of `drift_and_rotate`, so that a rebuild does not change results.
Vec4 spin_of(const Vec4& attitude, const Vec4& momentum, const Vec4& inertia);

// Moves centres and attitudes of own particles by dt at constant v and L, and computes their spins.
// Returns the largest displacement of a surface point since the poses given, m: the distance of the
// centres and the arc of the point that is farthest from the axis.
double drift_and_rotate(State& state, double dt, const std::vector<Vec4>& reference_x,
                        const std::vector<Vec4>& reference_q);

}  // namespace trackbed::dem
