// Weights are exact: of node n and rectangle R, with shape function N_n linear in each triangle T,
//   w_n = 1/|R| sum_T integral over R and T of N_n = 1/|R| sum_T |R T| N_n(centroid of R T),
// since the mean of a linear function over a polygon is its value at the centroid. So they sum to
// one, and their centre is that of the rectangle: no moment gets lost.
// Rejected: a share for each node inside, which jumps as a footprint moves across zones and has
// neither of the two.
#include "trackbed/couple/footprints.hpp"

#include <algorithm>
#include <map>

#include "trackbed/core/error.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::couple {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

// What of a convex polygon lies where sign (p[axis] - limit) <= 0 (Sutherland, Hodgman 1974).
Polygon cut(const Polygon& polygon, int axis, double limit, double sign) {
  Polygon kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Point &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double at_a = sign * (a[axis] - limit), at_b = sign * (b[axis] - limit);
    if (at_a <= 0) kept.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0))
      kept.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return kept;
}

// m^2 and m^3: area, and its first moment, positive if corners turn left.
struct Extent {
  double area = 0;
  Point moment = Point::Zero();
};
Extent extent_of(const Polygon& polygon) {
  Extent sum;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const double area = cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]) / 2;
    sum.area += area;
    sum.moment += area / 3 * (polygon[0] + polygon[k - 1] + polygon[k]);
  }
  return sum;
}

// Shape functions of a triangle's corners at a point.
std::array<double, 3> shape_at(const std::array<Point, 3>& corner, const Point& at) {
  const double whole = cross(corner[1] - corner[0], corner[2] - corner[0]);
  std::array<double, 3> shape{};
  for (std::size_t k = 0; k < 3; ++k)
    shape[k] = cross(corner[(k + 1) % 3] - at, corner[(k + 2) % 3] - at) / whole;
  return shape;
}

// Adds the weights a triangle's nodes get from one rectangle.
void add_triangle(const Surface& surface, const std::array<std::int32_t, 3>& triangle,
                  const Rectangle& r, std::map<std::int32_t, double>& weights) {
  std::array<Point, 3> corner;
  for (std::size_t k = 0; k < 3; ++k)
    corner[k] = surface.position[static_cast<std::size_t>(triangle[k])].head<2>();
  Polygon polygon(corner.begin(), corner.end());
  for (int axis = 0; axis < 2; ++axis) {
    const auto& range = axis == 0 ? r.x : r.y;
    polygon = cut(cut(polygon, axis, range[0], -1), axis, range[1], 1);
  }
  const Extent extent = extent_of(polygon);
  if (extent.area <= 0) return;
  const std::array<double, 3> shape = shape_at(corner, extent.moment / extent.area);
  const double share = extent.area / ((r.x[1] - r.x[0]) * (r.y[1] - r.y[0]));
  for (std::size_t k = 0; k < 3; ++k) weights[triangle[k]] += share * shape[k];
}

}  // namespace

Footprints::Footprints(const par::Comm& comm, const Surface& surface, std::vector<std::int32_t> own,
                       const std::vector<Rectangle>& rectangles)
    : comm_(comm) {
  for (const Rectangle& r : rectangles) {
    require(r.x[1] > r.x[0] && r.y[1] > r.y[0], "a footprint has a width and a length");
    std::map<std::int32_t, double> weights;
    for (const auto& triangle : surface.triangles) add_triangle(surface, triangle, r, weights);
    std::vector<Share> all, mine;
    for (const auto& [node, weight] : weights) {
      all.push_back({node, weight});
      const auto at = std::lower_bound(own.begin(), own.end(), node);
      if (at != own.end() && *at == node)
        mine.push_back({static_cast<std::int32_t>(at - own.begin()), weight});
    }
    shares_.push_back(std::move(all));
    own_shares_.push_back(std::move(mine));
  }
}

void Footprints::press(std::span<const double> forces, std::vector<Vec3>& nodes) const {
  require(forces.size() == count(), "one force for each footprint");
  for (std::size_t i = 0; i < count(); ++i)
    for (const Share& share : shares_[i])
      nodes.at(static_cast<std::size_t>(share.node)).z() -= share.weight * forces[i];
}

std::vector<std::vector<double>> Footprints::means(std::span<const Values> quantities) const {
  std::vector<std::int64_t> sums;
  for (const Values& quantity : quantities)
    for (const std::vector<Share>& shares : own_shares_) {
      ExactSum sum(exact_quantum(quantity.largest));
      for (const Share& share : shares)
        sum.add(share.weight * quantity.own.at(static_cast<std::size_t>(share.node)));
      sums.push_back(sum.count());
    }
  comm_.sum(std::span(sums));
  std::vector<std::vector<double>> means;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    means.emplace_back();
    for (std::size_t i = 0; i < count(); ++i) {
      ExactSum sum(exact_quantum(quantities[q].largest));
      sum.count() = sums[q * count() + i];
      means.back().push_back(sum.value());
    }
  }
  return means;
}

}  // namespace trackbed::couple
