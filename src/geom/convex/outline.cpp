// Outlines of plane stones.
//
// Corners are points of a superellipse |x/a|^n + |z/b|^n = 1 with a = 1, b = elongation, whose
// angles and radii scatter with the angularity; their hull is stretched until smallest width and
// largest extent have the required ratio. A star-shaped random outline would need no hull, but its
// dents would be filled by disks as large as the pebbles anyway.
//
// Key: hash of the seed and a number, so that an outline does not depend on earlier draws.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geom/convex/hull.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

// All pairs: with a dozen corners rotating calipers would gain nothing.
double largest_extent(const Polygon& polygon) {
  double largest = 0;
  for (const Point& a : polygon)
    for (const Point& b : polygon) largest = std::max(largest, (a - b).norm());
  return largest;
}

struct LeastWidth {
  double value = std::numeric_limits<double>::infinity();
  Point direction = Point::Zero();
};

// The smallest width of a convex polygon is reached across one of its edges (Houle, Toussaint 1988,
// doi:10.1109/34.6790). All edges against all corners: outlines have a dozen of them.
LeastWidth width_of(const Polygon& polygon) {
  LeastWidth smallest;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    const Point inward = Point(-edge.y(), edge.x()).normalized();
    double across = 0;
    for (const Point& p : polygon) across = std::max(across, inward.dot(p - polygon[i]));
    if (across < smallest.value) smallest = {across, inward};
  }
  return smallest;
}

// Radius of the superellipse in the direction of `angle`: (|cos|^n + (|sin|/b)^n)^(-1/n).
Polygon scattered_corners(const OutlineShape& shape, std::uint64_t seed) {
  const double exponent = 2 + 2 * shape.angularity;  // from an ellipse towards a rounded box
  Polygon points;
  for (int k = 0; k < shape.corners; ++k) {
    const auto key = static_cast<std::uint64_t>(k);
    const double turn = k + shape.angularity * (uniform(seed, 3 * key) - 0.5);
    const double angle = 2 * std::numbers::pi * turn / shape.corners;
    const double x = std::cos(angle), z = std::sin(angle);
    const double border = std::pow(
        std::pow(std::abs(x), exponent) + std::pow(std::abs(z) / shape.elongation, exponent),
        -1 / exponent);
    const double radius = border * (1 - 0.5 * shape.angularity * uniform(seed, 3 * key + 1));
    points.emplace_back(radius * x, radius * z);
  }
  return points;
}

// Compresses across the smallest width until its ratio to the largest extent is the required one.
// Each pass may change both, so it is repeated; near 1 a polygon of few corners cannot reach the
// ratio.
void stretch(Polygon& polygon, double elongation) {
  constexpr int passes = 100;
  constexpr double close = 1e-12;
  for (int pass = 0; pass < passes; ++pass) {
    const LeastWidth width = width_of(polygon);
    const double factor = elongation * largest_extent(polygon) / width.value;
    if (std::abs(factor - 1) < close) return;
    for (Point& p : polygon) p += (factor - 1) * width.direction.dot(p) * width.direction;
  }
}

}  // namespace

// Scaled last, since stretching changes the extent.
std::vector<Point> outline(const OutlineShape& shape, std::uint64_t seed) {
  Polygon polygon = convex_hull(scattered_corners(shape, seed));
  stretch(polygon, shape.elongation);
  const Vec3 centroid = polygon_solid(polygon).centre;
  const double extent = largest_extent(polygon);
  for (Point& p : polygon) p = (p - Point(centroid.x(), centroid.z())) / extent;
  return polygon;
}

double smallest_width(const std::vector<Point>& polygon) { return width_of(polygon).value; }

}  // namespace trackbed::geom
