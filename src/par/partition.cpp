// Three ways to partition work over ranks. Points by coordinates: recursive bisection across the
// longest side (Berger, Bokhari 1987, doi:10.1109/TC.1987.1676942), a sort per halving, compact
// boxes, no adjacency needed. Graphs and meshes by METIS (Karypis, Kumar 1998,
// doi:10.1137/S1064827595287997), which cuts fewer edges but needs the adjacency.
//
// All are local: ranks that run them on the same input compute the same partition without a
// message. The treatment of ties and the seeds are therefore part of the result.
#include "trackbed/par/partition.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "trackbed/core/error.hpp"

namespace trackbed::par {

namespace {

// Assigns `parts` consecutive part numbers from `first` to the points listed in `names`. Points are
// sorted by coordinate, equal ones by number, so that the partition is the same wherever it is
// computed.
void bisect_range(std::span<const Vec3> points, std::span<const double> weights,
                  std::span<std::int32_t> names, int first, int parts, std::vector<int>& part_of) {
  if (parts == 1 || names.empty()) {
    for (const std::int32_t name : names) part_of[static_cast<std::size_t>(name)] = first;
    return;
  }
  Vec3 low = points[static_cast<std::size_t>(names[0])], high = low;
  double total = 0;
  for (const std::int32_t name : names) {
    low = low.cwiseMin(points[static_cast<std::size_t>(name)]);
    high = high.cwiseMax(points[static_cast<std::size_t>(name)]);
    total += weights[static_cast<std::size_t>(name)];
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::sort(names.begin(), names.end(), [&](std::int32_t a, std::int32_t b) {
    const double xa = points[static_cast<std::size_t>(a)][axis];
    const double xb = points[static_cast<std::size_t>(b)][axis];
    return xa != xb ? xa < xb : a < b;
  });
  // Odd numbers of parts: the lower side gets the corresponding fraction of the weight, not half of
  // it. A point goes to the side that contains most of its weight.
  const int lower_parts = parts / 2;
  const double wanted = total * lower_parts / parts;
  std::size_t cut = 0;
  for (double sum = 0; cut < names.size(); ++cut) {
    const double weight = weights[static_cast<std::size_t>(names[cut])];
    if (sum + 0.5 * weight >= wanted) break;
    sum += weight;
  }
  bisect_range(points, weights, names.first(cut), first, lower_parts, part_of);
  bisect_range(points, weights, names.subspan(cut), first + lower_parts, parts - lower_parts,
               part_of);
}

}  // namespace

std::vector<int> bisect(std::span<const Vec3> points, std::span<const double> weights, int parts) {
  require(points.size() == weights.size(), "bisect: one weight per point");
  std::vector<std::int32_t> names(points.size());
  std::iota(names.begin(), names.end(), 0);
  std::vector<int> part_of(points.size(), 0);
  bisect_range(points, weights, names, 0, parts, part_of);
  return part_of;
}

namespace {

// METIS counts in 32 bits: the weights are scaled so that its own sums do not overflow. They are at
// least 1, because METIS may put vertices of no weight into any part.
std::vector<idx_t> whole(std::span<const double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double unit = sum > 0 ? (1 << 28) / sum : 0;
  std::vector<idx_t> numbers(weights.size());
  for (std::size_t k = 0; k < weights.size(); ++k)
    numbers[k] = std::max<idx_t>(1, static_cast<idx_t>(unit * weights[k]));
  return numbers;
}

}  // namespace

// Empty if a partition is not possible: fewer vertices than parts, or METIS failed; the caller then
// keeps its bisection.
std::vector<int> partition_graph(const Graph& graph, int parts) {
  std::vector<int> part_of(graph.size(), 0);
  if (graph.size() < static_cast<std::size_t>(parts)) return {};
  if (parts == 1) return part_of;
  idx_t vertices = static_cast<idx_t>(graph.size()), constraints = 1, nparts = parts, cut = 0;
  std::vector<idx_t> begin(graph.begin.begin(), graph.begin.end());
  std::vector<idx_t> neighbours(graph.neighbours.begin(), graph.neighbours.end());
  std::vector<idx_t> weights = whole(graph.weights), edges = whole(graph.edge_weights);
  neighbours.resize(std::max<std::size_t>(neighbours.size(), 1));  // METIS refuses a null pointer
  edges.resize(neighbours.size());
  std::array<idx_t, METIS_NOPTIONS> options;
  METIS_SetDefaultOptions(options.data());
  // METIS begins from random vertices.
  options[METIS_OPTION_SEED] = 1;  // the same split on every rank and in every run
  // Recursive bisection balances few parts better, k-way is faster for many.
  const auto split = parts <= 8 ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  std::vector<idx_t> found(graph.size());
  const int status =
      split(&vertices, &constraints, begin.data(), neighbours.data(), weights.data(), nullptr,
            edges.data(), &nparts, nullptr, nullptr, options.data(), &cut, found.data());
  if (status != METIS_OK) return {};
  std::copy(found.begin(), found.end(), part_of.begin());
  return part_of;
}

// Cost of a part: its own weights and, for each cut edge, its weight on both sides, since both
// ranks compute the contacts along it. Largest over mean of the weights: 1 is ideal.
double worst_part(const Graph& graph, std::span<const int> part_of, int parts) {
  std::vector<double> cost(static_cast<std::size_t>(parts), 0);
  double sum = 0;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    double& mine = cost[static_cast<std::size_t>(part_of[v])];
    mine += graph.weights[v], sum += graph.weights[v];
    for (auto e = static_cast<std::size_t>(graph.begin[v]);
         e < static_cast<std::size_t>(graph.begin[v + 1]); ++e)
      if (part_of[static_cast<std::size_t>(graph.neighbours[e])] != part_of[v])
        mine += graph.edge_weights[e];
  }
  return sum > 0 ? *std::max_element(cost.begin(), cost.end()) * parts / sum : 1;
}

// By the dual graph: elements are neighbours if they have `common` nodes in common. If there are
// fewer elements than parts, all are on part 0.
std::vector<int> partition_mesh(std::span<const std::int32_t> element_nodes, int nodes_per_element,
                                int common, std::span<const double> weights, int parts) {
  // Offsets of equal length: all elements have the same number of nodes.
  idx_t elements = static_cast<idx_t>(element_nodes.size()) / nodes_per_element;
  std::vector<int> part_of(static_cast<std::size_t>(elements), 0);
  if (parts == 1 || elements < parts) return part_of;
  require(weights.size() == part_of.size(), "partition_mesh: one weight per element");
  std::vector<idx_t> nodes(element_nodes.begin(), element_nodes.end()), costs = whole(weights);
  std::vector<idx_t> begin(static_cast<std::size_t>(elements) + 1);
  for (std::size_t e = 0; e < begin.size(); ++e)
    begin[e] = static_cast<idx_t>(e) * nodes_per_element;
  idx_t node_count = *std::max_element(nodes.begin(), nodes.end()) + 1;
  idx_t ncommon = common, nparts = parts, cut = 0;
  std::vector<idx_t> element_part(part_of.size()), node_part(static_cast<std::size_t>(node_count));
  const int status = METIS_PartMeshDual(&elements, &node_count, begin.data(), nodes.data(),
                                        costs.data(), nullptr, &ncommon, &nparts, nullptr, nullptr,
                                        &cut, element_part.data(), node_part.data());
  require(status == METIS_OK, "METIS partitions the mesh");
  std::copy(element_part.begin(), element_part.end(), part_of.begin());
  return part_of;
}

}  // namespace trackbed::par
