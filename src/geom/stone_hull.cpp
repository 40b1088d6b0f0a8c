// CGAL stays in this file: its headers take seconds to compile and its types would spread.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_2.h>

#include "hull.hpp"

namespace trackbed::geom {

std::vector<Eigen::Vector2d> convex_hull(const std::vector<Eigen::Vector2d>& points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_2> given, corners;
  for (const auto& p : points) given.emplace_back(p.x(), p.y());
  CGAL::convex_hull_2(given.begin(), given.end(), std::back_inserter(corners));
  std::vector<Eigen::Vector2d> hull;
  for (const auto& p : corners) hull.emplace_back(p.x(), p.y());
  return hull;
}

}  // namespace trackbed::geom
