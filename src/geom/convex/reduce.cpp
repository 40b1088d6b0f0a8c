// Hulls with few corners for scans with many.
//
// Furthest point first, as in quickhull, but stopped early: each step adds the corner that is
// furthest outside. Cost: a hull of at most `vertices` points and a pass over all corners per step.
// The corners are a subset of those of the whole hull, so faces stay where the scan has them;
// collapsing edges would create new corners.
#include <algorithm>

#include "geom/convex/hull.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

namespace {

// Distance of a point outside of a polyhedron; for flatter cores its distance from the corners. The
// flat cases are used only in the first three steps, until there is a body.
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
  // At least four corners: fewer have no volume.
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
