// Magnitudes that can be used in computations. Private to the module.
//
// Double precision has 16 digits: a stiffness of 1e25 N/m in a sum with the 1e8 N/m of its
// neighbours leaves none of their digits, and squares of 1e300 are infinite. So each unit has a
// range, far wider than any real structure, in which products of a few quantities remain finite and
// sums with usual values keep their digits. Zero is not covered: the limits of the parameter decide
// on it. Ratios of values that enter one matrix are checked where it is assembled.
#pragma once

#include <array>
#include <cmath>
#include <string_view>

namespace trackbed::input {

struct Magnitudes {
  std::string_view unit;
  double least, most;
};

// A unit that is not listed is treated as a plain number.
inline Magnitudes magnitudes_of(std::string_view unit) {
  constexpr std::array<Magnitudes, 26> known{
      {{"-", 1e-15, 1e15},   {"m", 1e-25, 1e6},     {"mm", 1e-6, 1e6},       {"m2", 1e-12, 1e6},
       {"m4", 1e-18, 1e6},   {"1/m", 1e-6, 1e12},   {"radii", 1e-6, 1e3},    {"degrees", 1e-9, 1e6},
       {"%", 1e-9, 100},     {"s", 1e-12, 1e9},     {"1/s", 1e-9, 1e12},     {"Hz", 1e-9, 1e9},
       {"m/s", 1e-12, 1e5},  {"m/s2", 1e-9, 1e6},   {"m/s^2", 1e-9, 1e6},    {"kg", 1e-9, 1e9},
       {"kg/m", 1e-12, 1e9}, {"kg m2", 1e-9, 1e12}, {"kg/m3", 1e-3, 1e9},    {"kg/m^3", 1e-3, 1e9},
       {"N", 1e-9, 1e12},    {"N/m", 1e-3, 1e15},   {"N/m^1.5", 1e-3, 1e18}, {"N s/m", 1e-6, 1e12},
       {"Pa", 1e-3, 1e15},   {"Pa/m", 1e-3, 1e15}}};
  for (const Magnitudes& one : known)
    if (one.unit == unit) return one;
  return {unit, 1e-15, 1e15};
}

inline bool computable(const Magnitudes& range, double value) {
  const double size = std::abs(value);
  return size == 0 || (size >= range.least && size <= range.most);
}

}  // namespace trackbed::input
