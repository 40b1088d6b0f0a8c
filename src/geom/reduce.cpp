// Hulls of few corners for the many of a scan.
//
// Furthest point first, as in quickhull, but stopped early: each step takes the corner that the
// hull misses most. Cost: a hull of at most `vertices` points and a pass over all corners per step.
// The corners are some of those of the whole hull, so faces stay where the scan has them;
// collapsing edges would make new ones.
#include <algorithm>

#include "hull.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

namespace {

// How far a point sticks out of a polyhedron; of anything flatter, its distance from the corners.
// The flat cases guide only the first three steps, until there is a body.
double outside(const Convex& core, const Vec3& p) {
  double height = 0;
  if (core.faces.size() > 2) {
    for (const Face& face : core.faces) height = std::max(height, face.normal.dot(p) - face.offset);
    return height;
  }
  // Distance from the span of the corners, then from the corners in it.
  Vec3 rest = p - core.vertices[0];
  if (core.faces.size() == 2) return std::abs(core.faces[0].normal.dot(rest));
  if (core.vertices.size() == 2) {
    const Vec3 along = (core.vertices[1] - core.vertices[0]).normalized();
    rest -= along.dot(rest) * along;
  }
  return rest.norm();
}

}  // namespace

Convex reduced_hull(const std::vector<Vec3>& points, int vertices) {
  const Convex whole = convex_hull(points);
  // Four corners at least: fewer have no volume.
  const auto wanted = static_cast<std::size_t>(std::max(4, vertices));
  if (whole.vertices.size() <= wanted) return whole;
  std::vector<Vec3> chosen{whole.vertices[0]};
  Convex core = convex_hull(chosen);
  while (chosen.size() < wanted) {
    const auto next = std::max_element(
        whole.vertices.begin(), whole.vertices.end(),
        [&](const Vec3& a, const Vec3& b) { return outside(core, a) < outside(core, b); });
    chosen.push_back(*next);
    core = convex_hull(chosen);
  }
  return core;
}

}  // namespace trackbed::geom
