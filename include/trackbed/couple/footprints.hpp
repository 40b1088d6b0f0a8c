// Rectangles on a surface through which bodies without a surface of their own load it: a force is
// distributed over a rectangle, uniformly or linearly across it, and to the nodes by shape
// functions; the motion below it is the mean with the same weights, so that force, moment and work
// are equal on both sides.
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
  // 1/m: the pressure at y is 1 + tilt (y - middle) times its mean. For a length L across, the
  // resultant acts tilt L^2/12 beside the middle, and the motion is the mean plus the least squares
  // slope across times the same distance.
  double tilt = 0;
  double middle_y() const { return (y[0] + y[1]) / 2; }
};

class Footprints {
 public:
  struct NodeWeight {
    std::int32_t node;
    double weight;  // sums to 1 over the nodes of a footprint that is entirely on the surface
  };
  // Weights follow from the present positions of the nodes, equal on all ranks. `own`: nodes that
  // this rank moves, in the order of the values given below. Cost: rectangles times faces, which
  // are whole faces of hexahedra and triangles otherwise.
  Footprints(const par::Comm& comm, const Surface& surface, std::vector<std::int32_t> own,
             const std::vector<Rectangle>& rectangles);

  std::size_t count() const { return weights_.size(); }
  const std::vector<NodeWeight>& weights(std::size_t i) const { return weights_.at(i); }
  // Adds forces (N, downwards, one per footprint) to those of the surface's nodes, identically on
  // all ranks.
  void add_forces(std::span<const double> forces, std::vector<Vec3>& nodes) const;

  // A quantity at the own nodes; its sums must be below `largest`.
  struct Values {
    std::vector<double> own;
    double largest;
  };
  // Means of each quantity over each footprint, bitwise identical on any number of ranks.
  // Collective, one reduction.
  std::vector<std::vector<double>> means(std::span<const Values> quantities) const;

 private:
  par::Comm comm_;
  std::vector<std::vector<NodeWeight>> weights_;
  // The same for own nodes: index in `own`, weight.
  std::vector<std::vector<NodeWeight>> own_weights_;
};

}  // namespace trackbed::couple
