// Convex hulls, private to the module.
//
// Two levels: hulls of triangles from CGAL, exact but with slivers on faces that are flat up to
// rounding; and cores made of them, whose faces are polygons. Contacts need the second: a face cut
// into slivers has edges that are not edges of the body.
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
// Of coincident points the first counts.
std::vector<Triangle> hull_triangles(const std::vector<Vec3>& points);

double extent_of(const std::vector<Vec3>& points);  // m, diagonal of the box around them

// As `convex_of`, but corners may be outside of faces by `slack` times the extent.
Convex assemble(std::vector<Vec3> vertices, const std::vector<std::vector<int>>& faces,
                double slack);

}  // namespace trackbed::geom
