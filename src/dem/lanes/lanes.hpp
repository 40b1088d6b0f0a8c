// Eight doubles that are computed together. Comparisons give a mask for `select`; there are no
// branches, so every lane does the same arithmetic and its result does not depend on its place. The
// vector type of the compilers is used and not the intrinsics of one machine: the same source is
// eight doubles wide everywhere, and every operation is rounded like the scalar one, which does not
// hold for intrinsics that estimate 1/x or 1/sqrt(x). Functions are always inlined: vectors as
// arguments of real calls would go through memory.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "dem/lanes/vec4.hpp"

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
// A loop, because the extension has no square root; compilers can make it one instruction.
[[gnu::always_inline]] inline Lanes root(Lanes a) {
  Lanes result;
  for (std::size_t k = 0; k < lanes; ++k) result[k] = std::sqrt(a[k]);
  return result;
}
// Whether any lane is set.
[[gnu::always_inline]] inline bool any(Mask m) {
  m |= __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3);
  m |= __builtin_shufflevector(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
  return (m[0] | m[1]) != 0;
}

// The same for one number: a formula written as a template serves eight contacts in lanes and a
// single one, with the same roundings.
[[gnu::always_inline]] inline double select(bool mask, double yes, double no) {
  return mask ? yes : no;
}
[[gnu::always_inline]] inline double larger(double a, double b) { return a > b ? a : b; }
[[gnu::always_inline]] inline double smaller(double a, double b) { return a < b ? a : b; }
[[gnu::always_inline]] inline double root(double a) { return std::sqrt(a); }
[[gnu::always_inline]] inline bool any(bool mask) { return mask; }

// One vector (Real = double) or eight (Real = Lanes).
template <class Real>
struct Triple {
  Real x, y, z;
};
using Lanes3 = Triple<Lanes>;

template <class Real>
[[gnu::always_inline]] inline Triple<Real> operator+(const Triple<Real>& a, const Triple<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
[[gnu::always_inline]] inline Triple<Real> operator-(const Triple<Real>& a, const Triple<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Factor, class Real>
[[gnu::always_inline]] inline Triple<Real> operator*(Factor s, const Triple<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
[[gnu::always_inline]] inline Real dot(const Triple<Real>& a, const Triple<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
[[gnu::always_inline]] inline Triple<Real> cross(const Triple<Real>& a, const Triple<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Test, class Real>
[[gnu::always_inline]] inline Triple<Real> select(Test mask, const Triple<Real>& yes,
                                                  const Triple<Real>& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}

inline Triple<double> triple(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 vec3(const Triple<double>& v) { return {v.x, v.y, v.z}; }

// Eight doubles from an aligned array and back.
[[gnu::always_inline]] inline Lanes load(const double* from) {
  Lanes value;
  __builtin_memcpy(&value, __builtin_assume_aligned(from, 64), sizeof value);
  return value;
}
[[gnu::always_inline]] inline void store(Lanes value, double* to) {
  __builtin_memcpy(__builtin_assume_aligned(to, 64), &value, sizeof value);
}

// Eight vectors as plain arrays, for loops that the compiler vectorises. Two forms, since some
// loops are written lane by lane and vectorised by the compiler (laws) and some are written in
// whole lanes (features).
struct alignas(64) Lane3 {
  double x[lanes], y[lanes], z[lanes];
  void put(std::size_t k, const Vec4& v) { x[k] = v.x, y[k] = v.y, z[k] = v.z; }
  void put(std::size_t k, const Vec3& v) { x[k] = v.x(), y[k] = v.y(), z[k] = v.z(); }
  void put(std::size_t k, double a, double b, double c) { x[k] = a, y[k] = b, z[k] = c; }
  Vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
  [[gnu::always_inline]] Lanes3 get() const { return {dem::load(x), dem::load(y), dem::load(z)}; }
  [[gnu::always_inline]] void set(const Lanes3& v) {
    dem::store(v.x, x), dem::store(v.y, y), dem::store(v.z, z);
  }
};

// v turned by the unit quaternion (u, w): v + 2 w u x v + 2 u x (u x v).
template <class Real>
[[gnu::always_inline]] inline Triple<Real> turned(const Triple<Real>& u, Real w,
                                                  const Triple<Real>& v) {
  Triple<Real> uv = cross(u, v);
  uv = {uv.x + uv.x, uv.y + uv.y, uv.z + uv.z};
  const Triple<Real> uuv = cross(u, uv);
  return {v.x + w * uv.x + uuv.x, v.y + w * uv.y + uuv.y, v.z + w * uv.z + uuv.z};
}

// From space to the axes of a body with the attitude q (x y z w): by the conjugate.
template <class Real>
[[gnu::always_inline]] inline Triple<Real> to_body(const Real (&q)[4], const Triple<Real>& v) {
  return turned(Triple<Real>{-q[0], -q[1], -q[2]}, q[3], v);
}

}  // namespace trackbed::dem
