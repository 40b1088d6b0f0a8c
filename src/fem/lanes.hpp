// Eight zones at once, and the sums and differences in which a box is simple.
//
// The mirror symmetries of a box tie a pattern of signs over its corners (or Gauss points) to few
// others: stiffness.hpp, pattern_map.hpp. Results do not depend on the lane a zone falls into.
#pragma once

#include <Eigen/Dense>
#include <bit>
#include <cstdint>
#include <cstring>

namespace trackbed::fem {

constexpr std::int32_t lanes = 8;
// One number of eight zones. Plain multiplications and additions on it round as scalars do, so the
// result does not depend on which lane, or how full a vector, a zone falls into.
using Lane = double __attribute__((vector_size(8 * lanes)));

// Loads and stores are unaligned: a zone's right corners are its left ones shifted by one.
inline Lane load(const double* from) {
  Lane value;
  std::memcpy(&value, from, sizeof(Lane));
  return value;
}
inline void store(double* to, const Lane& value) { std::memcpy(to, &value, sizeof(Lane)); }

// Sums and differences over the corners: bit a of the index turns from "which corner along axis a"
// into "differs along axis a".
template <int D>
inline void to_patterns(Lane (&value)[1 << D]) {
  for (int bit = 1; bit < 1 << D; bit <<= 1)
    for (int k = 0; k < 1 << D; ++k)
      if ((k & bit) == 0) {
        const Lane low = value[k], high = value[k | bit];
        value[k] = low + high;
        value[k | bit] = high - low;
      }
}
// The way back, transposed: corner k gets the sum over patterns of sign * value.
template <int D>
inline void to_corners(Lane (&value)[1 << D]) {
  for (int bit = 1; bit < 1 << D; bit <<= 1)
    for (int k = 0; k < 1 << D; ++k)
      if ((k & bit) == 0) {
        const Lane even = value[k], odd = value[k | bit];
        value[k] = even - odd;
        value[k | bit] = even + odd;
      }
}

// +1 or -1: the sign a pattern gives to a corner, the product over the axes of the pattern.
inline double pattern_sign(int pattern, int corner) {
  return std::popcount(static_cast<unsigned>(pattern & ~corner)) % 2 != 0 ? -1.0 : 1.0;
}

// to_patterns as a matrix, on numbers ordered components * corner + component.
inline Eigen::MatrixXd patterns_of(int corners, int components) {
  const int size = corners * components;
  Eigen::MatrixXd patterns = Eigen::MatrixXd::Zero(size, size);
  for (int p = 0; p < corners; ++p)
    for (int corner = 0; corner < corners; ++corner)
      for (int c = 0; c < components; ++c)
        patterns(p * components + c, corner * components + c) = pattern_sign(p, corner);
  return patterns;
}

}  // namespace trackbed::fem
