// Common description of everything that stones touch: a set of triangles with moving nodes, owned
// by some continuum (ground top, sleeper, platen, wall). Contact mechanics and structures exchange
// data only through it.
//
// Inside a time window of length dt the nodes move linearly:
//   X(s) = position + s * motion,  s in [0, 1],   velocity = motion / dt.
// Topology (triangles, material) is the same on every rank; node motion is filled at least for the
// nodes near the rank's stones. Triangle normals (counter-clockwise) point towards the stones.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed {

// Load on one node from stones, gathered over the sub-steps k = 1..n of a window as exact sums (see
// exact_sum.hpp): `force` is the sum of F_k, `first` the sum of (k/n) F_k. With the second one the
// moment about a point can be computed exactly although the node moves during the window.
struct NodeLoad {
  std::array<std::int64_t, 3> force{};
  std::array<std::int64_t, 3> first{};
};

struct Surface {
  std::string name;
  int material = 0;                                    // index into the contact materials
  std::vector<std::array<std::int32_t, 3>> triangles;  // node numbers
  std::vector<Vec3> position;                          // m, at the start of the window
  std::vector<Vec3> motion;                            // m, over the window
  std::vector<NodeLoad> load;                          // quanta of `load_quantum`
  double load_quantum = 0;                             // N, power of two, same on all ranks

  std::size_t nodes() const { return position.size(); }
  void clear_load() { load.assign(nodes(), NodeLoad{}); }
};

}  // namespace trackbed
