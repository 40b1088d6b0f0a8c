// Hulls by CGAL, which is confined to the files named ..._cgal.cpp: its headers take seconds to
// compile and its types would spread.
//
// Kernel: exact predicates (is a point above a plane?) by interval arithmetic, with exact numbers
// where that is inconclusive, and coordinates in double, since a hull makes no new points. Space:
// quickhull (Barber, Dobkin, Huhdanpaa 1996, doi:10.1145/235815.235821).
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <map>

#include "geom/convex/hull.hpp"
#include "geom/convex/kernel.hpp"

namespace trackbed::geom {

std::vector<Eigen::Vector2d> convex_hull(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Kernel::Point_2> given, corners;
  for (const auto& p : points) given.emplace_back(p.x(), p.y());
  CGAL::convex_hull_2(given.begin(), given.end(), std::back_inserter(corners));
  std::vector<Eigen::Vector2d> hull;
  for (const auto& p : corners) hull.emplace_back(p.x(), p.y());
  return hull;
}

std::vector<Triangle> hull_triangles(const std::vector<Vec3>& points) {
  std::vector<Kernel::Point_3> given;
  std::map<Kernel::Point_3, int>
      number;  // CGAL copies points: they are identified by their coordinates
  for (const Vec3& p : points) {
    number.insert({Kernel::Point_3(p.x(), p.y(), p.z()), static_cast<int>(given.size())});
    given.emplace_back(p.x(), p.y(), p.z());
  }
  // As a half-edge mesh: with a set of indexed triangles, hulls were wrong
  // (docs/decisions/shapes.md). For points without volume it has no faces.
  CGAL::Surface_mesh<Kernel::Point_3> hull;
  CGAL::convex_hull_3(given.begin(), given.end(), hull);
  std::vector<Triangle> triangles;
  for (const auto face : hull.faces()) {
    Triangle triangle{};
    std::size_t k = 0;
    for (const auto v : hull.vertices_around_face(hull.halfedge(face)))
      triangle[k++] = number.at(hull.point(v));
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    triangles.push_back(triangle);
  }
  // CGAL's order follows the addresses of its vertices, which differ from run to run.
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace trackbed::geom
