// Extremes over time of each element's stress at its centre: static stress plus stress since
// settling.
//
// They are running extremes and part of the state in checkpoints: a history of all elements would
// be terabytes, and extremes of snapshots miss those between them. Cost per instant: one stress and
// its principal values per element, as much as some ten explicit steps; taken at history rows and
// fields.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "fem/material/mohr_coulomb.hpp"

namespace trackbed::fem {

class Extremes {
 public:
  struct Quantity {
    const char *name, *meaning;  // all in Pa
    double sign;                 // 1: largest, -1: least
    double (*of)(const Vec6& stress, const Vec3& principal);
  };
  static constexpr std::size_t count = 5;
  static const std::array<Quantity, count>& quantities();

  explicit Extremes(std::size_t elements)
      : values(count * elements, std::numeric_limits<double>::quiet_NaN()) {}
  // The first stress of an element is both maximum and minimum.
  void take(std::size_t element, const Vec6& stress);

  std::vector<double> values;  // element by element; NaN before the first
};

}  // namespace trackbed::fem
