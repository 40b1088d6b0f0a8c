// Openings that stones pass: slots in a plane, square holes in space.
//
// A body passes a square hole if its projection along some direction fits into the square. All
// directions and rotations about them are tried on a raster; from the best of them a search with
// halving steps follows, since the smallest projection of a stone with corners is at a kink that a
// raster misses.
//
// Sieves have square holes, so gradings refer to this size and not to a diameter. It is the hole
// for a stone that moves straight through in its best attitude; on a real sieve it reaches that
// attitude by shaking. Cost: 1000 directions x 30 rotations x corners for the raster, once per
// template.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using std::numbers::pi;

// The width of a union of balls along a direction is that of its hull; the swept hull of corners
// has the same, so rounded pieces need no faces here.
double width_along(const std::vector<Sphere>& spheres, const Vec3& direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Sphere& s : spheres) {
    const double along = direction.dot(s.centre);
    low = std::min(low, along - s.radius);
    high = std::max(high, along + s.radius);
  }
  return high - low;
}

// A direction of view: along the third column, sides of the square along the others.
struct View {
  Mat3 axes;
  double side;
};

View view_of(const std::vector<Sphere>& spheres, const Mat3& axes) {
  return {axes, std::max(width_along(spheres, axes.col(0)), width_along(spheres, axes.col(1)))};
}

// A quarter turn maps the square onto itself: larger angles need not be tried.
View best_turn(const std::vector<Sphere>& spheres, const Vec3& direction) {
  constexpr int turns = 30;  // 3 degrees apart
  const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
  View best{Mat3::Zero(), std::numeric_limits<double>::infinity()};
  for (int k = 0; k < turns; ++k) {
    const double angle = pi / 2 * k / turns, c = std::cos(angle), s = std::sin(angle);
    Mat3 axes;
    axes << c * u + s * v, c * v - s * u, direction;
    const View view = view_of(spheres, axes);
    if (view.side < best.side) best = view;
  }
  return best;
}

// Rotates about three axes and their diagonals by a step that is halved when no rotation improves
// the result. Diagonals are included, since at a kink several widths are equally large and a
// rotation about one axis alone reduces one and increases another.
View refined(const std::vector<Sphere>& spheres, View best) {
  // Half the raster's spacing; at the end the error of the width is far below the accuracy of a
  // grading.
  constexpr double start = 0.04, end = 1e-7;  // radians
  // Usually about a hundred; a cuboid has views whose sides fall by rounding errors without end.
  constexpr int most_tries = 1000;
  double step = start;
  for (int tries = 0; tries < most_tries && step > end; ++tries) {
    View next = best;
    for (int k = 0; k < 27; ++k) {
      const Vec3 about(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (about.isZero()) continue;
      const Mat3 turn = Eigen::AngleAxisd(step, about.normalized()).toRotationMatrix();
      const View view = view_of(spheres, turn * best.axes);
      if (view.side < next.side) next = view;
    }
    if (next.side < best.side)
      best = next;
    else
      step /= 2;
  }
  return best;
}

}  // namespace

// No search follows: the error is second order except at kinks, where it is half a step times the
// extent.
double smallest_slot(const std::vector<Sphere>& disks) {
  constexpr int turns = 720;  // a quarter of a degree apart: 0.2 % of the extent at most
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < turns; ++k) {
    const double angle = pi * k / turns;
    smallest = std::min(smallest, width_along(disks, {std::cos(angle), 0, std::sin(angle)}));
  }
  return smallest;
}

double smallest_hole(const std::vector<Sphere>& spheres) {
  // Half a sphere, as the view from behind is the same (lattice: Gonzalez 2010,
  // doi:10.1007/s11004-009-9257-x).
  constexpr int directions = 1000;  // Fibonacci lattice on half a sphere
  // Several, since the best of the raster need not belong to the best minimum.
  constexpr std::size_t kept = 12;
  std::vector<View> views;
  for (int k = 0; k < directions; ++k) {
    const double z = (k + 0.5) / directions, r = std::sqrt(1 - z * z);
    const double turn = 2 * pi * k / std::numbers::phi;
    views.push_back(best_turn(spheres, {r * std::cos(turn), r * std::sin(turn), z}));
  }
  std::partial_sort(views.begin(), views.begin() + kept, views.end(),
                    [](const View& a, const View& b) { return a.side < b.side; });
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < kept; ++k)
    smallest = std::min(smallest, refined(spheres, views[k]).side);
  return smallest;
}

double smallest_hole(const std::vector<Piece>& pieces) {
  std::vector<Sphere> corners;
  for (const Piece& piece : pieces)
    for (const Vec3& corner : piece.core.vertices) corners.push_back({corner, piece.radius});
  return smallest_hole(corners);
}

}  // namespace trackbed::geom
