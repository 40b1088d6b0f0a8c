#include "fem/mesh/split.hpp"

#include <algorithm>

#include "trackbed/par/partition.hpp"

namespace trackbed::fem {

std::vector<int> split_nodes(const ElementGraph& elements, std::span<const double> cost,
                             std::span<const std::int32_t> node_of, std::size_t nodes, int ranks) {
  const auto part =
      par::partition_mesh(elements.corners, elements.per_element, elements.common, cost, ranks);
  const std::size_t each = node_of.size() / part.size();
  std::vector<int> owner(nodes, ranks);
  for (std::size_t at = 0; at < node_of.size(); ++at) {
    int& mine = owner[static_cast<std::size_t>(node_of[at])];
    mine = std::min(mine, part[at / each]);
  }
  return owner;
}

}  // namespace trackbed::fem
