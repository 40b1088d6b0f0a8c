// Meshes for the tests of decomposition and of mass properties.
#pragma once

#include <array>
#include <vector>

#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

// An L of unit depth in y, three long and three high, legs one thick.
inline Mesh letter() {
  const std::vector<Eigen::Vector2d> outline{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  Mesh mesh;
  for (const double y : {0.0, 1.0})
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), y, p.y());
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a + 6, c + 6, b + 6});
  }
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    mesh.triangles.push_back({k, k + 6, next + 6});
    mesh.triangles.push_back({k, next + 6, next});
  }
  return mesh;
}

inline Mesh ball_mesh() { return surface_of(ball({0, 0, 0}, 1), 12); }

inline Mesh cube() {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1, k >> 1 & 1, k >> 2);
  return surface_of({convex_hull(corners), 0});
}

}  // namespace trackbed::geom
