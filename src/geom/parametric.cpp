// Irregular convex stones of a wanted number of corners.
//
// A stone has a few main corners c_j and is worn. Its support function is
//   h(d) = (sum_j max(0, d . c_j)^p + (rho |d|)^p)^(1/p),
// convex as a p-norm of convex functions: the hull of the main corners for rho = 0 and p large, a
// ball of radius rho where the c_j vanish. Support points x(d) = grad h(d) of directions d spread
// over the sphere gather around the main corners as those of a real stone do. (Points at given
// directions on a superellipsoid, the usual way, cut the corners: at proportions near 1 their
// sphericity does not fall below 0.8.) All of them are corners in exact arithmetic; if some do not
// stand out clearly, the stone is worn a little more. Stretching along the axes keeps corners
// corners and makes the proportions exact.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

constexpr double pi = std::numbers::pi;

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

// At an angularity of 0 the main corners vanish and rho is 1: an even ball. All draws come before
// the wear, so that how much a stone is worn changes no draw.
std::vector<Vec3> all_corners(const StoneShape& shape, std::uint64_t seed) {
  constexpr double clear = 2e-3;  // of the extent a corner stands out at least
  constexpr double wear = 0.05;
  Draw draw(seed);
  const int count = 4 + static_cast<int>(3 * draw());
  std::vector<Vec3> main_corners = spread_directions(count, shape.angularity, draw);
  for (Vec3& c : main_corners) c *= shape.angularity;
  const auto directions = spread_directions(shape.vertices, shape.angularity / 2, draw);
  for (double rho = 1 - 0.7 * shape.angularity; rho < 3; rho += wear) {
    const std::vector<Vec3> points = support_points(directions, main_corners, rho);
    if (convex_hull(points, clear).vertices.size() == points.size()) return points;
  }
  throw std::invalid_argument("no stone of this many corners: 6 to 200 are possible");
}

}  // namespace

// Stretching is affine, so it keeps the hull convex and its corners corners; the hull is made anew
// for the faces' normals.
Convex stone(const StoneShape& shape, std::uint64_t seed) {
  std::vector<Vec3> points = all_corners(shape, seed);
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vec3 wanted(1, shape.elongation, shape.elongation * shape.flatness);
  const Vec3 stretch = wanted.cwiseQuotient(high - low);
  for (Vec3& p : points) p = p.cwiseProduct(stretch);
  const Convex hull = convex_hull(points);
  return moved(hull, Quat::Identity(), -piece_solid({hull, 0}).centre);
}

}  // namespace trackbed::geom
