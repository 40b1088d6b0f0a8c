// Eight doubles that are computed together. Comparisons give a mask for `select`; there are no
// branches, so every lane does the same arithmetic and its bits do not depend on its place.
// The compilers' own vector type and not the intrinsics of one machine: the same source is eight
// doubles wide everywhere, and every operation is rounded as its scalar is, which intrinsics for
// estimates of 1/x or 1/sqrt(x) would not be. Functions are inlined by force: vectors as arguments
// of real calls would go through memory.
#pragma once

#include <cmath>
#include <cstddef>

#include "vec4.hpp"

namespace trackbed::dem {

inline constexpr std::size_t lanes = 8;  // doubles in a 512-bit register

// Vector extension of GCC and Clang: two or four registers where they are narrower.
using Lanes [[gnu::vector_size(64)]] = double;
using Mask = decltype(Lanes{} < Lanes{});

[[gnu::always_inline]] inline Lanes all(double value) { return Lanes{} + value; }
[[gnu::always_inline]] inline Lanes select(Mask mask, Lanes yes, Lanes no) {
  return mask ? yes : no;
}
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
[[gnu::always_inline]] inline Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
// Whether it holds in any lane.
[[gnu::always_inline]] inline bool any(Mask m) {
  m |= __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3);
  m |= __builtin_shufflevector(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
  return (m[0] | m[1]) != 0;
}
// A loop, for the extension has no root; compilers can make it one instruction.
[[gnu::always_inline]] inline Lanes root(Lanes a) {
  Lanes result;
  for (std::size_t k = 0; k < lanes; ++k) result[k] = std::sqrt(a[k]);
  return result;
}

// Eight vectors.
struct Lanes3 {
  Lanes x, y, z;
};
[[gnu::always_inline]] inline Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Lanes3 operator*(Lanes s, const Lanes3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
[[gnu::always_inline]] inline Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Lanes3 select(Mask mask, const Lanes3& yes, const Lanes3& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}

// Eight vectors as plain arrays, for loops that the compiler vectorises.
// Two forms of the same, since some loops are written lane by lane and vectorised by the compiler
// (laws) and some are written in whole lanes (features).
struct alignas(64) Lane3 {
  double x[lanes], y[lanes], z[lanes];
  void put(std::size_t k, const Vec4& v) { x[k] = v.x, y[k] = v.y, z[k] = v.z; }
  void put(std::size_t k, const Vec3& v) { x[k] = v.x(), y[k] = v.y(), z[k] = v.z(); }
  void put(std::size_t k, double a, double b, double c) { x[k] = a, y[k] = b, z[k] = c; }
  Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
};

}  // namespace trackbed::dem
