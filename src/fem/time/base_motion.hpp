// The wave that enters through a viscous base: its velocity at the base as a function of time.
//
// Given is the motion of the incident wave alone, as it would propagate in a ground that continues
// below: half of the motion of an outcrop of that ground.
#pragma once

#include <string>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::fem {

class BaseMotion {
 public:
  // Table with columns time_s, vx_m_s, vz_m_s. Rows at its begin and end with at most 1e-9 of the
  // largest speed count as zero; the first and the last row must be zero. Throws InputError. Local:
  // every rank reads it.
  explicit BaseMotion(const std::string& path);

  // m/s at `time` (s) since the ground started to move: linear between rows, 0 before and after.
  Vec3 at(double time) const;
  double fastest() const;      // m/s, of the rows
  bool moves(int axis) const;  // whether there is motion along x (0) or z (2)
  // s, the interval outside of which the motion is zero; without any motion the last time of the
  // table twice.
  double begin() const;
  double end() const;

 private:
  void require_zero_ends(const std::string& path, const std::vector<int>& lines);

  std::vector<double> times_;
  std::vector<Vec3> rows_;  // m/s
};

}  // namespace trackbed::fem
