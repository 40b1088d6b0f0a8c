// Cost of elements for the partition of a ground among ranks, and the partition of tetrahedra.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// Cost of an element in a window of one explicit step; that of an elastic element is 1. Yielding
// solids are tested in each step; below the stones each window gathers the load of the nodes and
// publishes their motion. Measured: docs/decisions/ground_elements.md.
struct ElementCost {
  double yields, interface;
  double of(const Strength& strength, bool at_interface) const {
    return 1 + (strength.yield == Yield::none ? 0 : yields) + (at_interface ? interface : 0);
  }
};
inline constexpr ElementCost brick_cost{1.3, 1.4}, tetrahedron_cost{0.6, 0.2};

// Elements of a mesh with a constant number of corners; neighbours share `common` of them, a face.
struct ElementGraph {
  std::span<const std::int32_t> corners;
  int per_element, common;
};

// Of tetrahedra, the owner of each of `nodes` nodes: the lowest rank among those of the elements
// around it, a rule that every rank can apply alone. METIS partitions the elements into equal sums
// of `cost`. `node_of`: all nodes of the elements in turn, the same number for each. Local: every
// rank computes all owners.
std::vector<int> split_nodes(const ElementGraph& elements, std::span<const double> cost,
                             std::span<const std::int32_t> node_of, std::size_t nodes, int ranks);

}  // namespace trackbed::fem
