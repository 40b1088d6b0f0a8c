// What forces on the rails do to the rails elsewhere, without solving for the whole track.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "trackbed/track/line.hpp"

namespace trackbed::track {

class Influence {
 public:
  // `matrix`: symmetric, positive definite, of a line whose rails have these nodes; N/m and the
  // like for rotations.
  Influence(const Sparse& matrix, const std::vector<RailNodes>& nodes);

  // m/N, what a force at each point of a rail does to each other, `local` left out; rows and
  // columns of points beyond the track are zero.
  Eigen::MatrixXd between(const std::vector<RailPoint>& points) const;

 private:
  using Cut = Eigen::Matrix4d;
  struct Point;
  struct Waves;
  struct Place {
    std::int32_t node = -1, number = -1;  // of a rail's unknown: its node, which of the node's
  };
  void eliminate(const Sparse& matrix, const std::vector<RailNodes>& nodes);
  Point point(const RailPoint& of, std::size_t number) const;
  Cut way(std::int32_t from, std::int32_t to) const;

  std::vector<Place> place_;          // of each unknown
  std::vector<Cut> pass_;             // P
  std::vector<Cut> alone_, inverse_;  // B, G
};

}  // namespace trackbed::track
