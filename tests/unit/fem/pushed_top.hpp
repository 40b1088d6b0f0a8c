// A non-uniform load on the top of a ground, and the resulting displacements.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

inline std::vector<Vec3> uneven_load(const Surface& top, int window) {
  std::vector<Vec3> force(top.nodes());
  for (std::size_t n = 0; n < force.size(); ++n)
    force[n] = {30 * std::sin(0.3 * static_cast<double>(n) + window), 0,
                -100 * (1 + std::sin(0.9 * window + 0.2 * static_cast<double>(n)))};
  return force;
}

// Displacements of all top nodes, the same on every rank.
inline std::vector<double> shape_of(const par::Comm& comm, Ground& ground) {
  std::vector<double> all(3 * ground.top().nodes(), 0.0);
  for (const std::int32_t n : ground.own_top())
    for (int c = 0; c < 3; ++c)
      all[static_cast<std::size_t>(3 * n + c)] = ground.top_state(n).displacement[c];
  comm.sum(std::span(all));
  return all;
}

}  // namespace trackbed::fem
