// Four doubles in one aligned line: the data of the inner loops, read with a single load.
#pragma once

#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::dem {

struct alignas(32) Vec4 {
  double x = 0, y = 0, z = 0, w = 0;
  Vec3 vec3() const { return {x, y, z}; }
  void set(const Vec3& v) { x = v.x(), y = v.y(), z = v.z(); }
};

// Order x y z w in memory, as in Eigen; Eigen's constructor takes w first.
inline Quat quat(const Vec4& q) { return Quat(q.w, q.x, q.y, q.z); }
inline Vec4 vec4(const Vec3& v) { return {v.x(), v.y(), v.z(), 0}; }
inline Vec4 vec4(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }

// The larger of two; what is not a number is larger than any, and stays so.
inline double not_below(double a, double least) { return a <= least || least != least ? least : a; }

}  // namespace trackbed::dem
