// Weights are exact: of node n and rectangle R, with shape function N_n in each face T,
//   w_n = 1/|R| sum_T integral over R and T of N_n p,   p = 1 + tilt (y - middle).
// On triangles N_n p is of second degree, whose mean over a triangular part is that at the middles
// of its sides; on faces of hexahedra the intersection of R and T is a rectangle, on which N_n is a
// function of x times one of y. So the weights sum to one, and their centre is that of the
// pressure: the moment is conserved. With a tilt some weights are negative.
//
// Faces of hexahedra are whole rectangles with the bilinear functions of the elements below: a
// uniform pressure then gives each node its tributary area. Two triangles along one diagonal would
// give the nodes at its ends twice the load of the other two, and a uniform pressure would bend the
// top. A face is a pair of consecutive triangles abc and acd that form a rectangle; triangles of
// tetrahedra do not start at a common node, and uniform loads on them need the triangles
// (fem/mesh/flat_top.hpp).
//
// Rejected: an equal weight for each node inside, which is discontinuous as a footprint moves
// across elements and conserves neither force nor moment.
#include "trackbed/couple/footprints.hpp"

#include <algorithm>
#include <map>

#include "trackbed/core/error.hpp"
#include "trackbed/core/fine_sum.hpp"

namespace trackbed::couple {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

// The part of a convex polygon with sign (p[axis] - limit) <= 0 (Sutherland, Hodgman 1974).
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

double area_of(const Rectangle& r) { return (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]); }

// Relative to the mean pressure.
double pressure(const Rectangle& r, double y) { return 1 + r.tilt * (y - r.middle_y()); }

// Shape functions of a triangle's corners at a point.
std::array<double, 3> shape_at(const std::array<Point, 3>& corner, const Point& at) {
  const double whole = cross(corner[1] - corner[0], corner[2] - corner[0]);
  std::array<double, 3> shape{};
  for (std::size_t k = 0; k < 3; ++k)
    shape[k] = cross(corner[(k + 1) % 3] - at, corner[(k + 2) % 3] - at) / whole;
  return shape;
}

// Adds the weights of a triangle's nodes for one rectangle.
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
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const std::array<Point, 3> part = {polygon[0], polygon[k - 1], polygon[k]};
    const double area = cross(part[1] - part[0], part[2] - part[0]) / 2;
    if (area <= 0) continue;
    for (std::size_t side = 0; side < 3; ++side) {
      const Point middle = (part[side] + part[(side + 1) % 3]) / 2;
      const double fraction = area / 3 / area_of(r) * pressure(r, middle.y());
      const std::array<double, 3> shape = shape_at(corner, middle);
      for (std::size_t n = 0; n < 3; ++n) weights[triangle[n]] += fraction * shape[n];
    }
  }
}

// The same for a rectangular face, if this triangle and the next form one. Returns whether they do:
// deformed faces do not.
bool add_rectangle(const Surface& surface, std::size_t half, const Rectangle& r,
                   std::map<std::int32_t, double>& weights) {
  if (half + 1 >= surface.triangles.size()) return false;
  const auto [a, b, c] = surface.triangles[half];
  const auto [again, opposite, d] = surface.triangles[half + 1];
  if (again != a || opposite != c) return false;
  const auto at = [&](std::int32_t n) -> Point {
    return surface.position[static_cast<std::size_t>(n)].head<2>();
  };
  const Point low = at(a), high = at(c), size = high - low;
  constexpr double rounding = 1e-12;  // of the size
  const Point off_b = at(b) - Point(high.x(), low.y()), off_d = at(d) - Point(low.x(), high.y());
  if (size.minCoeff() <= 0 || std::max(off_b.norm(), off_d.norm()) > rounding * size.norm())
    return false;
  const Point from = low.cwiseMax(Point(r.x[0], r.y[0])), to = high.cwiseMin(Point(r.x[1], r.y[1]));
  if (from.x() >= to.x() || from.y() >= to.y()) return true;
  const double fraction = (to - from).prod() / area_of(r);
  const Point middle = (from + to) / 2, local = (middle - low).cwiseQuotient(size);
  const double length = to.y() - from.y();
  const double here = pressure(r, middle.y()), rise = r.tilt * length * length / 12 / size.y();
  const double at_low = here * (1 - local.y()) - rise, at_high = here * local.y() + rise;
  weights[a] += fraction * (1 - local.x()) * at_low;
  weights[b] += fraction * local.x() * at_low;
  weights[c] += fraction * local.x() * at_high;
  weights[d] += fraction * (1 - local.x()) * at_high;
  return true;
}

std::map<std::int32_t, double> weights_of(const Surface& surface, const Rectangle& r) {
  std::map<std::int32_t, double> weights;
  for (std::size_t t = 0; t < surface.triangles.size();) {
    const bool whole = add_rectangle(surface, t, r, weights);
    if (!whole) add_triangle(surface, surface.triangles[t], r, weights);
    t += whole ? 2 : 1;
  }
  return weights;
}

}  // namespace

Footprints::Footprints(const par::Comm& comm, const Surface& surface, std::vector<std::int32_t> own,
                       const std::vector<Rectangle>& rectangles)
    : comm_(comm) {
  for (const Rectangle& r : rectangles) {
    require(r.x[1] > r.x[0] && r.y[1] > r.y[0], "a footprint has a width and a length");
    std::vector<NodeWeight> all, mine;
    for (const auto& [node, weight] : weights_of(surface, r)) {
      all.push_back({node, weight});
      const auto at = std::lower_bound(own.begin(), own.end(), node);
      if (at != own.end() && *at == node)
        mine.push_back({static_cast<std::int32_t>(at - own.begin()), weight});
    }
    weights_.push_back(std::move(all));
    own_weights_.push_back(std::move(mine));
  }
}

void Footprints::add_forces(std::span<const double> forces, std::vector<Vec3>& nodes) const {
  require(forces.size() == count(), "one force for each footprint");
  for (std::size_t i = 0; i < count(); ++i)
    for (const NodeWeight& of : weights_[i])
      nodes.at(static_cast<std::size_t>(of.node)).z() -= of.weight * forces[i];
}

std::vector<std::vector<double>> Footprints::means(std::span<const Values> quantities) const {
  std::vector<std::int64_t> sums;
  for (const Values& quantity : quantities)
    for (const std::vector<NodeWeight>& weights : own_weights_) {
      FineSum sum(quantity.largest);
      for (const NodeWeight& of : weights)
        sum.add(of.weight * quantity.own.at(static_cast<std::size_t>(of.node)));
      sums.insert(sums.end(), sum.counts().begin(), sum.counts().end());
    }
  comm_.sum(std::span(sums));
  std::vector<std::vector<double>> means;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    means.emplace_back();
    for (std::size_t i = 0; i < count(); ++i) {
      FineSum sum(quantities[q].largest);
      const std::size_t at = 2 * (q * count() + i);
      sum.counts() = {sums[at], sums[at + 1]};
      sum.carry();
      means.back().push_back(sum.value());
    }
  }
  return means;
}

}  // namespace trackbed::couple
