// Vectors of eight elements, and the sums and differences in which the stiffness of a box is
// sparse.
//
// Due to the mirror symmetries of a box a sign pattern over its corners (or Gauss points) is
// coupled to few others: stiffness.hpp, pattern_map.hpp. Results do not depend on the lane of an
// element.
#pragma once

#include <Eigen/Dense>
#include <bit>
#include <cstdint>
#include <cstring>

namespace trackbed::fem {

constexpr std::int32_t lanes = 8;
// One value of eight elements. Rounding of plain multiplications and additions is that of scalars,
// so the result does not depend on the lane of an element or on how full a vector is.
using Lane = double __attribute__((vector_size(8 * lanes)));

// Loads and stores are unaligned: the right corners of an element are its left ones shifted by one.
inline Lane load(const double* from) {
  Lane value;
  std::memcpy(&value, from, sizeof(Lane));
  return value;
}
inline void store(double* to, const Lane& value) { std::memcpy(to, &value, sizeof(Lane)); }

// Sums and differences over the corners: bit a of the index changes its meaning from "which corner
// along axis a" to "differs along axis a".
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
// The transpose: corner k gets the sum over patterns of sign * value.
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

// +1 or -1: sign of a pattern at a corner, the product over the axes of the pattern.
inline double pattern_sign(int pattern, int corner) {
  return std::popcount(static_cast<unsigned>(pattern & ~corner)) % 2 != 0 ? -1.0 : 1.0;
}

// to_patterns as a matrix, on values ordered components * corner + component.
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
