// Influence coefficients of the rails: deflections at points of the rails due to forces at others,
// without a solve of the whole track.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "trackbed/track/line.hpp"

namespace trackbed::track {

class Influence {
 public:
  // `matrix`: symmetric, positive definite, of a line whose rails have these nodes; N/m, N m for
  // rotations.
  Influence(const Sparse& matrix, const std::vector<RailNodes>& nodes);

  // m/N, deflection at each point of a rail due to a unit force at each other, without `local`;
  // rows and columns of points beyond the track are zero.
  Eigen::MatrixXd between(const std::vector<RailPoint>& points) const;

 private:
  using Block = Eigen::Matrix4d;
  struct Point;
  struct Responses;
  struct Place {
    std::int32_t node = -1, number = -1;  // of a rail's unknown: its node, its index at the node
  };
  void eliminate(const Sparse& matrix, const std::vector<RailNodes>& nodes);
  Point point(const RailPoint& of, std::size_t number) const;
  Block transfer(std::int32_t from, std::int32_t to) const;

  std::vector<Place> place_;            // of each unknown
  std::vector<Block> transfer_;         // P
  std::vector<Block> partial_, whole_;  // B, G
};

}  // namespace trackbed::track
