// Small grounds for tests.
#pragma once

#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

inline GroundParameters box(const Vec3& size, std::array<std::int64_t, 3> zones,
                            const Elastic& solid) {
  GroundParameters p;
  p.x = {0, size.x()};
  p.y = {0, size.y()};
  p.zones_x = zones[0], p.zones_y = zones[1], p.zones_z = zones[2];
  p.layers = {{"all", size.z(), solid}};
  return p;
}

// Uniform vertical pressure (Pa) as consistent nodal forces of the top face; a plane model's two
// faces share the force.
inline std::vector<Vec3> pressure(Ground& ground, double pressure) {
  const Surface& top = ground.top();
  std::vector<Vec3> force(top.nodes(), Vec3::Zero());
  for (const auto& t : top.triangles) {
    const Vec3 a = top.position[static_cast<std::size_t>(t[0])];
    const Vec3 b = top.position[static_cast<std::size_t>(t[1])];
    const Vec3 c = top.position[static_cast<std::size_t>(t[2])];
    const double area = 0.5 * std::abs((b - a).cross(c - a).z());
    for (const auto n : t) force[static_cast<std::size_t>(n)].z() -= pressure * area / 3;
  }
  // Triangles weigh corners unevenly; on a regular mesh the even share is half per line end.
  return force;
}

}  // namespace trackbed::fem
