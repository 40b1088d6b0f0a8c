// Irregular convex stones with a given number of corners.
//
// A stone has a few main corners c_j and is worn. Its support function is
//   h(d) = (sum_j max(0, d . c_j)^p + (rho |d|)^p)^(1/p),
// convex as a p-norm of convex functions: the hull of the main corners for rho = 0 and p large, a
// ball of radius rho if the c_j vanish. Support points x(d) = grad h(d) of directions d spread
// over the sphere concentrate around the main corners as those of a real stone do. (Points in given
// directions on a superellipsoid, the usual method, cut the corners: at proportions near 1 their
// sphericity does not fall below 0.8.) All of them are corners in exact arithmetic; if some do not
// stand out clearly, the wear is increased. Then the stone is stretched along its own width and
// thickness until these have the required proportions to its length, as measured by callipers on
// the rounded stone (Zingg 1935; review: Blott, Pye 2008, doi:10.1111/j.1365-3091.2007.00892.x).
// The wear is also increased if this fails: a ball is nearest to proportions of 1.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using std::numbers::pi;

// Numbers in [0, 1) that depend on the seed and the order of calls.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : seed_(seed) {}
  double operator()() { return uniform(seed_, key_++); }

 private:
  std::uint64_t seed_, key_ = 0;
};

// Uniform random rotation (Shoemake 1992, in Graphics Gems III).
Quat random_turn(Draw& draw) {
  const double share = draw(), p = 2 * pi * draw(), q = 2 * pi * draw();
  const double a = std::sqrt(1 - share), b = std::sqrt(share);
  return {b * std::cos(q), a * std::sin(p), a * std::cos(p), b * std::sin(q)};
}

// Fibonacci lattice, each point moved at random by up to half of `scatter` spacings.
std::vector<Vec3> spread_directions(int count, double scatter, Draw& draw) {
  const double reach = scatter * std::sqrt(4 * pi / count);
  const Quat turn = random_turn(draw);
  std::vector<Vec3> directions;
  for (int k = 0; k < count; ++k) {
    const double z = 1 - 2 * (k + 0.5) / count, r = std::sqrt(1 - z * z);
    const double angle = 2 * pi * k / std::numbers::phi;
    const double x = draw(), y = draw();
    const Vec3 aside = Vec3(x, y, draw()) - Vec3::Constant(0.5);
    const Vec3 even(r * std::cos(angle), r * std::sin(angle), z);
    directions.push_back(turn * (even + reach * aside).normalized());
  }
  return directions;
}

// With S = sum (d . c_j)^p + rho^p at |d| = 1, grad h = S^(1/p - 1) (sum (d . c_j)^(p-1) c_j +
// rho^p d).
std::vector<Vec3> support_points(const std::vector<Vec3>& directions,
                                 const std::vector<Vec3>& main_corners, double rho) {
  constexpr double p = 6;  // large enough for corners, small enough for edges between them
  std::vector<Vec3> points;
  for (const Vec3& d : directions) {
    double sum = std::pow(rho, p);
    Vec3 gradient = sum * d;
    for (const Vec3& c : main_corners) {
      const double along = std::max(0.0, d.dot(c));
      sum += std::pow(along, p);
      gradient += std::pow(along, p - 1) * c;
    }
    points.push_back(std::pow(sum, 1 / p - 1) * gradient);
  }
  return points;
}

// m, radius of rounding of a core that gives a stone of this rounding, by Steiner's formula. The
// difference of both sides has one root: the radius grows faster than the diameter of the ball.
double radius_of(const Convex& core, double rounding, double extent) {
  if (rounding == 0) return 0;
  const Steiner s = steiner_of(core);
  double low = 0, high = extent;
  constexpr int halvings = 60;  // to the last bit
  for (int k = 0; k < halvings; ++k) {
    const double r = (low + high) / 2;
    const double volume = s.volume + r * (s.area + r * (s.bend + r * 4 * pi / 3));
    (r < rounding * std::cbrt(6 * volume / pi) ? low : high) = r;
  }
  return (low + high) / 2;
}

// A stone with its measures by callipers.
struct MeasuredStone {
  Piece stone;
  Callipers core;  // of its core
};

MeasuredStone measured(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& faces,
                       double rounding) {
  MeasuredStone m{{convex_of(points, faces), 0}, {}};
  m.core = callipers_of(m.stone.core);
  m.stone.radius = radius_of(m.stone.core, rounding, m.core.length);
  return m;
}

void stretch(std::vector<Vec3>& points, const Vec3& along, double factor) {
  for (Vec3& p : points) p += (factor - 1) * along.dot(p) * along;
}

// Length 1 along x, width along y, thickness along z, about the centre of mass.
Piece upright(const MeasuredStone& m) {
  const Quat turn(Mat3(m.core.axes.transpose()));
  const double length = m.core.length + 2 * m.stone.radius;
  Piece piece{scaled(moved(m.stone.core, turn, Vec3::Zero()), 1 / length), m.stone.radius / length};
  piece.core = moved(piece.core, Quat::Identity(), -piece_solid(piece).centre);
  return piece;
}

// Stretches width and thickness of the core until the stone has the required proportions.
// Stretching is affine, so the hull stays convex and keeps its corners and faces; but another width
// may then be the smallest, so it is repeated. Near proportions of 1 bodies of few corners do not
// converge: nothing is returned then.
std::optional<Piece> proportioned(const Convex& hull, const StoneShape& shape, double rounding) {
  constexpr int passes = 60;
  constexpr double close = 1e-10;  // of the sides
  std::vector<std::vector<int>> faces;
  for (const Face& face : hull.faces) faces.push_back(face.vertices);
  std::vector<Vec3> points = hull.vertices;
  for (int pass = 0; pass < passes; ++pass) {
    const MeasuredStone m = measured(points, faces, rounding);
    const double both = 2 * m.stone.radius, width = shape.elongation * (m.core.length + both);
    const double wide = (width - both) / m.core.width;
    const double thick = (shape.flatness * width - both) / m.core.thickness;
    if (std::max(std::abs(wide - 1), std::abs(thick - 1)) < close) return upright(m);
    constexpr double most =
        0.5;  // the radius falls with the core, so that a solution remains possible
    stretch(points, m.core.axes.col(1), std::max(wide, most));
    stretch(points, m.core.axes.col(2), std::max(thick, most));
  }
  return {};
}

// At an angularity of 0 the main corners vanish and rho is 1: an even ball. All random numbers are
// drawn before the wear, so that the amount of wear does not change them.
std::optional<Piece> drawn(const StoneShape& shape, double rounding, std::uint64_t seed) {
  constexpr double clear = 2e-3;  // of the extent a corner stands out at least
  constexpr double wear = 0.05;
  Draw draw(seed);
  const int count = 4 + static_cast<int>(3 * draw());
  std::vector<Vec3> main_corners = spread_directions(count, shape.angularity, draw);
  for (Vec3& c : main_corners) c *= shape.angularity;
  const auto directions = spread_directions(shape.vertices, shape.angularity / 2, draw);
  for (double rho = 1 - 0.7 * shape.angularity; rho < 3; rho += wear) {
    const std::vector<Vec3> points = support_points(directions, main_corners, rho);
    if (convex_hull(points, clear).vertices.size() != points.size()) continue;
    if (std::optional<Piece> stone = proportioned(convex_hull(points), shape, rounding))
      return stone;
  }
  return {};
}

}  // namespace

// Keys beyond those of the polyhedron's draws, so that a spread does not change the polyhedra.
StoneShape proportions_of(const StoneShape& shape, std::uint64_t seed) {
  if (shape.spread == 0) return shape;
  constexpr std::uint64_t beyond = std::uint64_t{1} << 32;
  constexpr double least = 0.1, most = 0.95;  // what stones of 6 corners and more reach
  const auto around = [&](double wanted, std::uint64_t key) {
    const double off = shape.spread * (2 * uniform(seed, beyond + key) - 1);
    return std::clamp(wanted + off, std::min(least, wanted), std::max(most, wanted));
  };
  StoneShape own = shape;
  own.elongation = around(shape.elongation, 0), own.flatness = around(shape.flatness, 1);
  own.spread = 0;
  return own;
}

Piece rounded_stone(const StoneShape& shape, double rounding, std::uint64_t seed) {
  const StoneShape own = proportions_of(shape, seed);
  if (std::optional<Piece> stone = drawn(own, rounding, seed)) return *stone;
  throw std::invalid_argument(fmt::format(
      "no stone with {} corners has an elongation of {:g} and a flatness of {:g} with a rounding "
      "of {:g}; use more corners for proportions near 1, or less rounding for very flat stones",
      own.vertices, own.elongation, own.flatness, rounding));
}

Convex stone(const StoneShape& shape, std::uint64_t seed) {
  return rounded_stone(shape, 0, seed).core;
}

}  // namespace trackbed::geom
