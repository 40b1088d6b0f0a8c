// Weights are exact: of node n and rectangle R, with shape function N_n in each face T,
//   w_n = 1/|R| sum_T integral over R and T of N_n p,   p = 1 + tilt (y - middle).
// On triangles N_n p is of second degree, whose mean over a part of R T is that of the middles of
// its sides; on zones R T is a rectangle, where N_n is a function of x times one of y. So weights
// sum to one, and their centre is that of the pressure: no moment gets lost. Of a tilt some are
// negative.
//
// Faces of zones are whole rectangles with bilinear functions, those of the elements below: an even
// pressure then gives each node its tributary area. Halves along one diagonal give the nodes at its
// ends twice what the other two get, and an even pressure bends the top. A zone is two triangles
// abc and acd in turn that are a rectangle; faces of tetrahedra have none, whose triangles share no
// such begin, and even loads on them need the triangles (fem/flat_top.hpp).
//
// Rejected: a share for each node inside, which jumps as a footprint moves across zones and has
// neither of the two.
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

double area_of(const Rectangle& r) { return (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]); }

// Of the mean pressure.
double pressure(const Rectangle& r, double y) { return 1 + r.tilt * (y - r.middle_y()); }

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
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const std::array<Point, 3> part = {polygon[0], polygon[k - 1], polygon[k]};
    const double area = cross(part[1] - part[0], part[2] - part[0]) / 2;
    if (area <= 0) continue;
    for (std::size_t side = 0; side < 3; ++side) {
      const Point middle = (part[side] + part[(side + 1) % 3]) / 2;
      const double share = area / 3 / area_of(r) * pressure(r, middle.y());
      const std::array<double, 3> shape = shape_at(corner, middle);
      for (std::size_t n = 0; n < 3; ++n) weights[triangle[n]] += share * shape[n];
    }
  }
}

// The same for a whole zone, if this triangle and the next are one. Returns whether they are: not
// where a ground has moved.
bool add_zone(const Surface& surface, std::size_t half, const Rectangle& r,
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
  const double share = (to - from).prod() / area_of(r);
  const Point middle = (from + to) / 2, local = (middle - low).cwiseQuotient(size);
  const double length = to.y() - from.y();
  const double here = pressure(r, middle.y()), rise = r.tilt * length * length / 12 / size.y();
  const double at_low = here * (1 - local.y()) - rise, at_high = here * local.y() + rise;
  weights[a] += share * (1 - local.x()) * at_low;
  weights[b] += share * local.x() * at_low;
  weights[c] += share * local.x() * at_high;
  weights[d] += share * (1 - local.x()) * at_high;
  return true;
}

std::map<std::int32_t, double> weights_of(const Surface& surface, const Rectangle& r) {
  std::map<std::int32_t, double> weights;
  for (std::size_t t = 0; t < surface.triangles.size();) {
    const bool whole = add_zone(surface, t, r, weights);
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
    std::vector<Share> all, mine;
    for (const auto& [node, weight] : weights_of(surface, r)) {
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
      FineSum sum(quantity.largest);
      for (const Share& share : shares)
        sum.add(share.weight * quantity.own.at(static_cast<std::size_t>(share.node)));
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
