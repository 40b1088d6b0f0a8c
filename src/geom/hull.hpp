// Convex hull of points in a plane; the only place that knows CGAL.
#pragma once

#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::geom {

// Counter-clockwise, corners only. Exact predicates: no point is lost or kept by rounding.
std::vector<Eigen::Vector2d> convex_hull(const std::vector<Eigen::Vector2d>& points);

}  // namespace trackbed::geom
