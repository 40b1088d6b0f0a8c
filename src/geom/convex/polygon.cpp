// Mass properties of polygons and disks along their border.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geom/convex/mass.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

// Part of a convex polygon in the half-plane to the left of the line from `origin` along
// `direction` (Sutherland, Hodgman 1974, doi:10.1145/360767.360802).
Polygon clipped(const Polygon& polygon, const Point& origin, const Point& inward) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double depth_a = inward.dot(a - origin), depth_b = inward.dot(b - origin);
    if (depth_a >= 0) kept.push_back(a);
    if ((depth_a < 0) != (depth_b < 0)) kept.push_back(a + depth_a / (depth_a - depth_b) * (b - a));
  }
  return kept;
}

// Part of a convex polygon at least `distance` inside its border, for every distance for which it
// is not empty: offsetting the edges instead would require detection of edges that vanish.
Polygon inset(const Polygon& polygon, double distance) {
  Polygon result = polygon;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    const Point inward = Point(-edge.y(), edge.x()).normalized();
    result = clipped(result, polygon[i] + distance * inward, inward);
    if (result.empty()) break;
  }
  return result;
}

// Corners closer than `distance` to their predecessor are left out: one disk is sufficient there.
Polygon thinned(const Polygon& polygon, double distance) {
  Polygon kept;
  for (const Point& p : polygon)
    if (kept.empty() || (p - kept.back()).norm() > distance) kept.push_back(p);
  while (kept.size() > 1 && (kept.back() - kept.front()).norm() <= distance) kept.pop_back();
  return kept;
}

// Evenly along each edge, including its start but not its end, which belongs to the next edge, so
// that corners get one disk.
void place_along(const Polygon& ring, double radius, double gap, std::vector<Sphere>& disks) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point edge = ring[(i + 1) % ring.size()] - ring[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(edge.norm() / gap)));
    for (int k = 0; k < parts; ++k) {
      const Point p = ring[i] + edge * k / parts;
      disks.push_back({Vec3(p.x(), 0, p.y()), radius});
    }
  }
}

}  // namespace

// Green's theorem, edge by edge. Each edge p-q represents the triangle with the origin, of signed
// area (p x q)/2:
//   int x = area (p + q)/3,  int x x^T = area ((p+q)(p+q)^T + p p^T + q q^T)/12.
Solid polygon_solid(const std::vector<Point>& polygon) {
  Integrals sums;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const Vec3 a(p.x(), 0, p.y()), b(q.x(), 0, q.y());
    const double cross = p.x() * q.y() - q.x() * p.y();
    sums.volume += cross / 2;
    sums.first += cross / 6 * (a + b);
    sums.second +=
        cross / 24 * ((a + b) * (a + b).transpose() + a * a.transpose() + b * b.transpose());
  }
  return lamina_of(sums);
}

// Centres are on the outline offset inwards by the radius, so disks touch it from inside.
std::vector<Sphere> pebbles_inside(const std::vector<Point>& polygon, double radius,
                                   double spacing) {
  constexpr double crowded = 0.4;  // radii between corners that share a disk
  std::vector<Sphere> disks;
  place_along(thinned(inset(polygon, radius), crowded * radius), radius, spacing * radius, disks);
  if (disks.empty()) throw std::invalid_argument("no disk of this radius fits into the outline");
  return disks;
}

}  // namespace trackbed::geom
