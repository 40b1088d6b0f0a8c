// Splits of a model over ranks. Pure functions of their arguments, so every rank computes the same.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::par {

// Recursive coordinate bisection: part of each point such that the weights are even; cuts across
// the longest extent first (a long thin bed is cut along x). O(n log n).
std::vector<int> bisect(std::span<const Vec3> points, std::span<const double> weights, int parts);

// Dual-graph partition of a mesh by METIS (Karypis, Kumar 1998, doi:10.1137/S1064827595287997).
// `element_nodes`: nodes of all elements in turn, `nodes_per_element` each; neighbours share at
// least `common` nodes. Returns the part of each element.
std::vector<int> partition_mesh(std::span<const std::int32_t> element_nodes, int nodes_per_element,
                                int common, int parts);

}  // namespace trackbed::par
