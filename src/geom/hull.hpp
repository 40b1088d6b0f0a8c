// Convex hulls inside the room.
//
// Two levels: hulls of triangles from CGAL, exact but with slivers on faces that are flat up to
// rounding; and cores made of them, whose faces are polygons. Contacts want the second: a face cut
// into slivers has edges that are none.
#pragma once

#include <array>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/geom/convex.hpp"

namespace trackbed::geom {

using Triangle = std::array<int, 3>;

// Counter-clockwise, corners only. Exact predicates: no point is lost or kept by rounding.
std::vector<Eigen::Vector2d> convex_hull(const std::vector<Eigen::Vector2d>& points);

// Triangles of the hull, counter-clockwise seen from outside, as indices of the points; none if the
// points lie exactly in one plane.
// Of points given twice the first counts.
std::vector<Triangle> hull_triangles(const std::vector<Vec3>& points);

double extent_of(const std::vector<Vec3>& points);  // m, diagonal of the box around them

// `convex_of` that lets corners stick out of faces by `slack` times the extent.
Convex assemble(std::vector<Vec3> vertices, const std::vector<std::vector<int>>& faces,
                double slack);

}  // namespace trackbed::geom
