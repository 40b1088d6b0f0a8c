// Rectangles on a surface through which bodies that have no surface of their own press on it: a
// force is spread over a rectangle, evenly or rising linearly across it, and goes to the nodes by
// shape functions; the motion below it is the mean by the same weights, so that force, moment and
// work are the same on both sides.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::couple {

struct Rectangle {
  std::array<double, 2> x, y;  // m, from and to
  // 1/m: the pressure at y is 1 + tilt (y - middle) times its mean. Of a length L its force acts
  // tilt L^2/12 beside the middle and feels, besides the mean, the slope across (of least squares)
  // times as much.
  double tilt = 0;
  double middle_y() const { return (y[0] + y[1]) / 2; }
};

class Footprints {
 public:
  struct Share {
    std::int32_t node;
    double weight;  // of the nodes of a footprint: sums to 1 if all of it lies on the surface
  };
  // Weights follow from where the nodes are now, the same on all ranks. `own`: nodes this rank
  // moves, in the order in which values of them are given below. Cost: rectangles times faces,
  // which are the whole ones of zones and triangles of all else.
  Footprints(const par::Comm& comm, const Surface& surface, std::vector<std::int32_t> own,
             const std::vector<Rectangle>& rectangles);

  std::size_t count() const { return shares_.size(); }
  const std::vector<Share>& shares(std::size_t i) const { return shares_.at(i); }
  // Adds forces (N, downwards, one of each footprint) to those of the surface's nodes, all ranks
  // alike.
  void press(std::span<const double> forces, std::vector<Vec3>& nodes) const;

  // A quantity of the own nodes; sums of it must stay below `largest`.
  struct Values {
    std::vector<double> own;
    double largest;
  };
  // Means of each quantity over each footprint, the same bits on any number of ranks. Collective,
  // one reduction.
  std::vector<std::vector<double>> means(std::span<const Values> quantities) const;

 private:
  par::Comm comm_;
  std::vector<std::vector<Share>> shares_;
  // The same of own nodes: place in `own`, weight.
  std::vector<std::vector<Share>> own_shares_;
};

}  // namespace trackbed::couple
