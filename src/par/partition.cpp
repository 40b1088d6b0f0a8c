#include "trackbed/par/partition.hpp"

#include <metis.h>

#include <algorithm>
#include <numeric>

#include "trackbed/core/error.hpp"

namespace trackbed::par {

namespace {

// Gives `parts` consecutive part numbers from `first` to the points named in `names`.
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

std::vector<int> partition_mesh(std::span<const std::int32_t> element_nodes, int nodes_per_element,
                                int common, int parts) {
  idx_t elements = static_cast<idx_t>(element_nodes.size()) / nodes_per_element;
  std::vector<int> part_of(static_cast<std::size_t>(elements), 0);
  if (parts == 1 || elements < parts) return part_of;
  std::vector<idx_t> nodes(element_nodes.begin(), element_nodes.end());
  std::vector<idx_t> begin(static_cast<std::size_t>(elements) + 1);
  for (std::size_t e = 0; e < begin.size(); ++e)
    begin[e] = static_cast<idx_t>(e) * nodes_per_element;
  idx_t node_count = *std::max_element(nodes.begin(), nodes.end()) + 1;
  idx_t ncommon = common, nparts = parts, cut = 0;
  std::vector<idx_t> element_part(part_of.size()), node_part(static_cast<std::size_t>(node_count));
  const int status = METIS_PartMeshDual(&elements, &node_count, begin.data(), nodes.data(), nullptr,
                                        nullptr, &ncommon, &nparts, nullptr, nullptr, &cut,
                                        element_part.data(), node_part.data());
  require(status == METIS_OK, "METIS could not partition the mesh");
  std::copy(element_part.begin(), element_part.end(), part_of.begin());
  return part_of;
}

}  // namespace trackbed::par
