// Comparison of two grounds that should have equal motions at common nodes.
#pragma once

#include <algorithm>
#include <functional>

#include "unit/fem/yielding_scene.hpp"

namespace trackbed::fem {

// Nodal forces of a traction (Pa) on the top: each node gets its fraction of the adjacent elements.
// For a ground that has not moved: areas and positions are those of the present shape.
using Traction = std::function<Vec3(const Vec3&)>;
inline std::vector<Vec3> traction_forces(Ground& ground, const Traction& traction) {
  std::vector<Vec3> force = pressure(ground, 1);
  for (std::size_t n = 0; n < force.size(); ++n)
    force[n] = -force[n].z() * traction(ground.top().position[n]);
  return force;
}

inline std::vector<Vec3> none(Ground& ground) {
  return std::vector<Vec3>(ground.top().nodes(), Vec3::Zero());
}

// Top displacements along each axis while a wave passes: largest difference between nodes, and
// largest value, m. 60 windows of 1 ms. Collective.
struct Spread {
  double apart = 0, largest = 0;
};
inline Spread spread_in_a_wave(const par::Comm& comm, Ground& ground) {
  Spread found;
  for (int w = 0; w < 60; ++w) {
    ground.advance(1e-3, none(ground));
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (const auto n : ground.own_top()) {
      low = low.cwiseMin(ground.top_state(n).displacement);
      high = high.cwiseMax(ground.top_state(n).displacement);
    }
    for (int c = 0; c < 3; ++c) {
      const double top = comm.max(high[c]), bottom = -comm.max(-low[c]);
      found.apart = std::max(found.apart, top - bottom);
      found.largest = std::max(found.largest, std::abs(top));
    }
  }
  return found;
}

// Largest difference of displacement, velocity and vertical stress between the own top nodes of one
// ground and the nodes at `partner` of their positions of another one, which is built on each rank
// alone; relative to the largest values of the own ground. Collective.
inline double apart(const par::Comm& comm, Ground& own, Ground& whole,
                    const std::function<Vec3(const Vec3&)>& partner) {
  std::array<double, 3> largest{}, difference{};
  const Surface& all = whole.top();
  const Surface& top = own.top();
  for (const std::int32_t n : own.own_top()) {
    const auto at = static_cast<std::size_t>(n);
    const Vec3 place = partner(top.position[at] + top.motion[at]);
    std::size_t found = 0;
    for (std::size_t m = 1; m < all.nodes(); ++m)
      if ((all.position[m] + all.motion[m] - place).norm() <
          (all.position[found] + all.motion[found] - place).norm())
        found = m;
    const auto mine = own.top_state(n), other = whole.top_state(static_cast<std::int32_t>(found));
    const std::array<double, 3> size = {mine.displacement.norm(), mine.velocity.norm(),
                                        std::abs(mine.sigma_z)};
    const std::array<double, 3> off = {(mine.displacement - other.displacement).norm(),
                                       (mine.velocity - other.velocity).norm(),
                                       std::abs(mine.sigma_z - other.sigma_z)};
    for (std::size_t q = 0; q < 3; ++q) {
      largest[q] = std::max(largest[q], size[q]);
      difference[q] = std::max(difference[q], off[q]);
    }
  }
  double worst = 0;
  for (std::size_t q = 0; q < 3; ++q) {
    EXPECT_GT(comm.max(largest[q]), 0);
    worst = std::max(worst, comm.max(difference[q]) / comm.max(largest[q]));
  }
  return worst;
}

}  // namespace trackbed::fem
