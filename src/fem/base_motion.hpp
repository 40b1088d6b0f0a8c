// The wave that comes up through a quiet base: its velocity at the base as a function of time.
//
// Given is the motion of the wave alone, as it would pass in a ground that goes on below: half of
// what an outcrop of that ground shows. Its displacement, for the springs, is the exact integral of
// the linearly interpolated velocity.
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

  struct Motion {
    Vec3 velocity, displacement;  // m/s, m
  };
  // `time` (s) since the ground was let go. Before the table rest, after it the last place.
  // Displacement counts from time 0, whatever the wave did before: the ground is let go at rest.
  Motion at(double time) const;
  double fastest() const;      // m/s, of the rows
  bool moves(int axis) const;  // whether ever along x (0) or z (2)
  // s, outside of which all is at rest; without any motion the last time of the table twice.
  double begin() const;
  double end() const;

 private:
  void require_rest(const std::string& path, const std::vector<int>& lines);

  std::vector<double> times_;
  std::vector<Motion> rows_;
};

}  // namespace trackbed::fem
