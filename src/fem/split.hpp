// How a ground is shared by ranks: elements by what they cost, nodes after the elements.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// What an element costs its rank in a window of one explicit step: a sweep over an elastic one is
// 1. What may yield is tested in each step; below the stones each window gathers the load of the
// nodes and publishes their motion. Measured: docs/decisions/ground_elements.md.
struct ElementCost {
  double yields, interface;
  double of(const Strength& strength, bool at_interface) const {
    return 1 + (strength.yield == Yield::none ? 0 : yields) + (at_interface ? interface : 0);
  }
};
inline constexpr ElementCost zone_cost{1.3, 1.4}, tetrahedron_cost{0.6, 0.2};

// Elements of a mesh with a number of corners each; neighbours share `common` of them, a face.
struct ElementGraph {
  std::span<const std::int32_t> corners;
  int per_element, common;
};

// Which rank owns each of `nodes` nodes: the lowest one among the elements around, a rule every
// rank can apply alone. METIS splits the elements, even sums of `cost`. `node_of`: all nodes of the
// elements in turn, the same number each. Local: every rank computes the whole answer.
std::vector<int> split_nodes(const ElementGraph& elements, std::span<const double> cost,
                             std::span<const std::int32_t> node_of, std::size_t nodes, int ranks);

}  // namespace trackbed::fem
