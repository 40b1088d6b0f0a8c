// Rotation between two directions.
#pragma once

#include <cmath>

#include "trackbed/core/types.hpp"

namespace trackbed {

// Rotation of the direction of `from` onto that of `to`: the shortest, unless they are opposite
// within 1.4e-3 rad.
//   q = (1 + c, a x b) / sqrt(2 (1 + c)),  c = a . b
// Eigen's Quat::FromTwoVectors needs a singular value decomposition for half a turn, which costs
// the compiler 8 s in each file.
inline Quat rotation_onto(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const double c = b.dot(a);
  if (constexpr double opposite = 1e-6; 1 + c < opposite) {  // 1 + c has lost six digits or more
    const Vec3 across = a.unitOrthogonal();
    return rotation_onto(-a, b) * Quat(0, across.x(), across.y(), across.z());
  }
  const double s = std::sqrt((1 + c) * 2);
  const Vec3 axis = a.cross(b) * (1 / s);
  return {0.5 * s, axis.x(), axis.y(), axis.z()};
}

}  // namespace trackbed
