// Partitions of a model over ranks: pure functions of their arguments, equal on every rank.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::par {

// Recursive coordinate bisection: the part of each point such that the weights are even; cuts
// across the longest extent first (a long thin bed is cut along x). O(n log n).
std::vector<int> bisect(std::span<const Vec3> points, std::span<const double> weights, int parts);

// An undirected graph with weights, adjacency in rows: `neighbours` and `edge_weights` of vertex v
// are in [begin[v], begin[v + 1]); each edge is in both rows with the same weight.
struct Graph {
  std::vector<std::int64_t> begin{0};
  std::vector<std::int32_t> neighbours;
  std::vector<double> weights, edge_weights;  // any unit, >= 0
  std::size_t size() const { return begin.size() - 1; }
};

// Part of each vertex by METIS (Karypis, Kumar 1998, doi:10.1137/S1064827595287997): even sums of
// weights, small sum of the edges cut. Weights are rounded to 2^-28 of their sum. Empty if METIS
// fails or if there are fewer vertices than parts; `bisect` splits anything.
std::vector<int> partition_graph(const Graph& graph, int parts);

// Cost of the most expensive part over the mean weight: the largest sum of its weights and of the
// edges that it cuts. 1 is a perfect partition without communication.
double worst_part(const Graph& graph, std::span<const int> part_of, int parts);

// Dual-graph partition of a mesh by METIS: even sums of weights, few faces cut.
// `element_nodes`: nodes of all elements in turn, `nodes_per_element` each; neighbours share at
// least `common` nodes. `weights`: of each element, any unit, > 0. Returns the part of each
// element.
std::vector<int> partition_mesh(std::span<const std::int32_t> element_nodes, int nodes_per_element,
                                int common, std::span<const double> weights, int parts);

}  // namespace trackbed::par
