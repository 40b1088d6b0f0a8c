// The wave that comes up through a quiet base: its velocity at the base as a function of time.
//
// Given is the motion of the wave alone, as it would pass in a ground that goes on below: half of
// what an outcrop of that ground shows.
#pragma once

#include <string>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::fem {

class BaseMotion {
 public:
  // Table with columns time_s, vx_m_s, vz_m_s. Rows at its begin and end with less than 1e-9 of the
  // largest speed are at rest; the first and the last must be. Throws InputError. Local: every rank
  // reads it.
  explicit BaseMotion(const std::string& path);

  // m/s at `time` (s) since the ground was let go: linear between rows, 0 before and after them.
  Vec3 at(double time) const;
  double fastest() const;      // m/s, of the rows
  bool moves(int axis) const;  // whether ever along x (0) or z (2)
  // s, outside of which all is at rest; without any motion the last time of the table twice.
  double begin() const;
  double end() const;

 private:
  void require_rest(const std::string& path, const std::vector<int>& lines);

  std::vector<double> times_;
  std::vector<Vec3> rows_;  // m/s
};

}  // namespace trackbed::fem
