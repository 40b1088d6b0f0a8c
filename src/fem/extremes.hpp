// Extremes over time of each zone's stress, of rest and motion together, at its centre.
//
// Running extremes and so state, in checkpoints: a history of all zones would be terabytes, and
// extremes of snapshots miss what lies between. Cost per instant: one stress and its principal
// values per zone, as much as some ten explicit steps; taken at history rows and fields.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "mohr_coulomb.hpp"

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

  explicit Extremes(std::size_t zones)
      : values(count * zones, std::numeric_limits<double>::quiet_NaN()) {}
  // The first stress of a zone is both.
  void take(std::size_t zone, const Vec6& stress);

  std::vector<double> values;  // zone by zone; not a number before the first
};

}  // namespace trackbed::fem
