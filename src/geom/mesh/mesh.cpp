// Mass properties of meshes, and surfaces of pieces as meshes.
//
// Both require a closed mesh whose triangles are counter-clockwise seen from outside; an open mesh
// gives a meaningless number and no error. Cost: one pass over the triangles.
#include "trackbed/geom/mesh.hpp"

#include <numbers>

#include "geom/convex/hull.hpp"
#include "geom/convex/mass.hpp"

namespace trackbed::geom {

namespace {

// Directions over the sphere: an octahedron whose triangles are divided `fineness` times. The
// lattice points |i| + |j| + |k| = fineness are on the octahedron; k < 0 is added separately, so
// that the equator is not given twice. Triangles near the middle of an octant are larger than at
// its corners, which is sufficient for display, the only use.
std::vector<Vec3> ball_points(int fineness) {
  std::vector<Vec3> points;
  for (int i = -fineness; i <= fineness; ++i)
    for (int j = std::abs(i) - fineness; j <= fineness - std::abs(i); ++j) {
      const int k = fineness - std::abs(i) - std::abs(j);
      points.push_back(Vec3(i, j, k).normalized());
      if (k > 0) points.push_back(Vec3(i, j, -k).normalized());
    }
  return points;
}

}  // namespace

// Volume by the divergence theorem: signed tetrahedra between each triangle and one point. The
// point may be anywhere; with the mean of the vertices the tetrahedra are small, so that a scan far
// from its origin does not lose digits by cancellation.
Solid mesh_solid(const Mesh& mesh) {
  Vec3 middle = Vec3::Zero();  // sums about a point inside lose no digits
  for (const Vec3& p : mesh.vertices) middle += p / static_cast<double>(mesh.vertices.size());
  const auto at = [&](int v) -> Vec3 {
    return mesh.vertices[static_cast<std::size_t>(v)] - middle;
  };
  Integrals sums;
  for (const auto& [a, b, c] : mesh.triangles) add_tetrahedron(at(a), at(b), at(c), sums);
  Solid solid = solid_of(sums);
  solid.centre += middle;
  return solid;
}

double surface_area(const Mesh& mesh) {
  const auto at = [&](int v) { return mesh.vertices[static_cast<std::size_t>(v)]; };
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += (at(b) - at(a)).cross(at(c) - at(a)).norm() / 2;
  return area;
}

// The hull of balls at the corners is the swept core, so a hull of points on those balls is a mesh
// of it without separate cases for faces, edges and corners. Its points are renumbered: most of
// each ball is inside the hull and is left out.
Mesh surface_of(const Piece& piece, int fineness) {
  std::vector<Vec3> points;
  for (const Vec3& corner : piece.core.vertices) {
    if (piece.radius == 0) points.push_back(corner);
    if (piece.radius == 0) continue;
    for (const Vec3& d : ball_points(fineness)) points.push_back(corner + piece.radius * d);
  }
  Mesh mesh;
  std::vector<int> number(points.size(), -1);
  for (Triangle triangle : hull_triangles(points)) {
    for (int& v : triangle) {
      int& fresh = number[static_cast<std::size_t>(v)];
      if (fresh < 0) {
        fresh = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(points[static_cast<std::size_t>(v)]);
      }
      v = fresh;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace trackbed::geom
