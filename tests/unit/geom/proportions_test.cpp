// Proportions of stones: callipers on known bodies and compared with all directions, and stones
// that have the required proportions, rounding included.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom::proportions_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double rounding_error = 1e-12;  // of bodies about 1 large
const Quat oblique(Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()));

// Measured without using faces or edges.
double extent(const std::vector<Piece>& pieces, const Vec3& direction) {
  double low = 1e300, high = -low;
  for (const Piece& piece : pieces)
    for (const Vec3& corner : piece.core.vertices) {
      low = std::min(low, direction.dot(corner) - piece.radius);
      high = std::max(high, direction.dot(corner) + piece.radius);
    }
  return high - low;
}

Vec3 direction_of(std::uint64_t key) {
  const double z = 2 * uniform(7, 2 * key) - 1, turn = 2 * pi * uniform(7, 2 * key + 1);
  return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}

void expect_sides(const Callipers& box, double s, double i, double l, double error) {
  EXPECT_NEAR(box.thickness, s, error);
  EXPECT_NEAR(box.width, i, error);
  EXPECT_NEAR(box.length, l, error);
  EXPECT_NEAR((box.axes.transpose() * box.axes - Mat3::Identity()).norm(), 0, rounding_error);
  EXPECT_NEAR(box.axes.determinant(), 1, rounding_error);
}

Convex block(const Vec3& size) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(size.cwiseProduct(Vec3(k & 1, k / 2 & 1, k / 4 & 1)));
  return moved(convex_hull(corners), oblique, Vec3(3, 2, 1));
}

TEST(Callipers, KnownBodies) {
  const Convex cuboid = block({2, 3, 1.5});
  expect_sides(callipers_of(cuboid), 1.5, 2, 3, rounding_error);
  expect_sides(callipers_of({Piece{cuboid, 0.1}}), 1.7, 2.2, 3.2, rounding_error);
  EXPECT_NEAR(greatest_extent({Piece{cuboid, 0.1}}), std::sqrt(4 + 9 + 2.25) + 0.2, rounding_error);
  // Between opposite edges a regular tetrahedron is as thick as the cube around it, whose faces it
  // touches along diagonals.
  const double side = 1 / std::sqrt(2.0);
  const Convex tetrahedron =
      convex_hull({{0, 0, 0}, {side, side, 0}, {side, 0, side}, {0, side, side}});
  expect_sides(callipers_of(tetrahedron), side, side, side, rounding_error);
  expect_sides(callipers_of({ball({1, 2, 3}, 0.5)}), 1, 1, 1, rounding_error);
  const Convex segment = convex_hull({{0, 0, 0}, {0, 3, 4}});
  expect_sides(callipers_of({Piece{segment, 0.5}}), 1, 1, 6, rounding_error);
  expect_sides(callipers_of({Piece{convex_hull({{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}), 0.25}}), 0.5,
               2.4 + 0.5, 5.5, rounding_error);
}

// A small ball beside a large one does not change thickness and width in many attitudes; two of
// them near a plane on one side give a body with a single direction of thickness.
TEST(Callipers, SpheresOfDifferentRadii) {
  constexpr double search = 1e-6;
  const std::vector<Piece> pair{ball({0, 0, 0}, 1), ball(Vec3(0.6, 0, 0.8) * 2, 0.5)};
  const Callipers box = callipers_of(pair);
  EXPECT_NEAR(box.thickness, 2, search);
  EXPECT_NEAR(box.width, 2, search);
  EXPECT_NEAR(greatest_extent(pair), 3.5, rounding_error);
  // All in one plane but one, whose ball extends to one side: the thickness there is 1 + 0.5. In
  // this view the four touch a rectangle of 5 by 4.2 with all sides.
  std::vector<Piece> frame;
  for (const double x : {-2.0, 2.0})
    for (const double y : {-1.6, 1.6}) frame.push_back(ball(oblique * Vec3(x, y, 0), 0.5));
  frame.push_back(ball(oblique * Vec3(0, 0, 0.25), 0.75));
  expect_sides(callipers_of(frame), 1.5, 4.2, 5, search);
}

TEST(Callipers, NoDirectionIsThinner) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    std::vector<Vec3> points;
    for (std::uint64_t k = 0; k < 6 + seed; ++k)
      points.emplace_back(uniform(seed, 3 * k), 2 * uniform(seed, 3 * k + 1),
                          uniform(seed, 3 * k + 2));
    const std::vector<Piece> body{{convex_hull(points), 0.1}};
    const Callipers box = callipers_of(body);
    for (const auto& [column, side] :
         {std::pair{0, box.length}, {1, box.width}, {2, box.thickness}})
      EXPECT_NEAR(extent(body, box.axes.col(column)), side, rounding_error);
    double nearest = 9;
    for (std::uint64_t k = 0; k < 20000; ++k) {
      const Vec3 direction = direction_of(k), flat = direction.cross(box.axes.col(2)).normalized();
      nearest = std::min(nearest, extent(body, direction));
      ASSERT_GT(extent(body, flat), box.width - rounding_error);
    }
    EXPECT_GT(nearest, box.thickness - rounding_error);
    EXPECT_LT(nearest, 1.05 * box.thickness);  // 20000 directions: 1.4 degrees apart
  }
}

// Measured from the corners along the axes of the stone, and along others.
void expect_proportions(const Piece& stone, const StoneShape& shape) {
  constexpr double exact = 1e-9;
  const std::vector<Piece> pieces{stone};
  const double length = extent(pieces, Vec3::UnitX()), width = extent(pieces, Vec3::UnitY()),
               thickness = extent(pieces, Vec3::UnitZ());
  ASSERT_NEAR(length, 1, exact);
  ASSERT_NEAR(width, shape.elongation, exact);
  ASSERT_NEAR(thickness, shape.flatness * shape.elongation, exact);
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Vec3 direction = direction_of(k), flat = direction.cross(Vec3::UnitZ()).normalized();
    ASSERT_GT(extent(pieces, direction), thickness - exact);
    ASSERT_GT(extent(pieces, flat), width - exact);
  }
}

TEST(Proportions, AreTheRequestedOnes) {
  for (const int vertices : {6, 12, 24, 60})
    for (const double angularity : {0.0, 0.5, 1.0})
      for (const double rounding : {0.0, 0.02, 0.05, 0.1})
        for (const double elongation : {0.4, 0.75, 0.9})
          for (const double flatness : {0.5, 0.7, 0.9})
            for (std::uint64_t seed = 0; seed < 2; ++seed) {
              const StoneShape shape{elongation, flatness, angularity, vertices};
              const Piece stone = rounded_stone(shape, rounding, seed);
              ASSERT_EQ(stone.core.vertices.size(), static_cast<std::size_t>(vertices));
              ASSERT_NO_FATAL_FAILURE(expect_proportions(stone, shape))
                  << vertices << " corners, angularity " << angularity << ", rounding " << rounding
                  << ", " << elongation << " " << flatness << ", seed " << seed;
              const Solid solid = piece_solid(stone);
              ASSERT_NEAR(solid.centre.norm(), 0, rounding_error);
              ASSERT_NEAR(stone.radius, rounding * std::cbrt(6 * solid.volume / pi), 1e-11);
            }
}

// In any attitude, as a template and cut into pieces.
TEST(Proportions, StayWithTemplatesAndPieces) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const StoneShape shape{0.8, 0.65, 1, 12};
    const Piece whole = rounded_stone(shape, 0.05, seed);
    std::vector<Piece> pieces;
    for (const Convex& part : sliced(whole.core, 3)) pieces.push_back({part, whole.radius});
    const Template cut = template_of(pieces, piece_solid(whole), smallest_hole({whole}));
    const Callipers box = callipers_of(cut.pieces);
    EXPECT_NEAR(box.width / box.length, 0.8, 1e-9);
    EXPECT_NEAR(box.thickness / box.width, 0.65, 1e-9);
    EXPECT_EQ(rounded_stone(shape, 0.05, seed).core.vertices, whole.core.vertices);
  }
}

// The projection along the length fits between the jaws; no projection is thinner than the stone.
TEST(Proportions, TheSieveLiesBetweenThicknessAndWidth) {
  constexpr double search = 1e-6;
  for (const double flatness : {0.4, 0.7, 0.9})
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const Piece stone = rounded_stone({.elongation = 0.75, .flatness = flatness}, 0.05, seed);
      const double sieve = smallest_hole({stone});
      EXPECT_GT(sieve, 0.75 * flatness - search);
      EXPECT_LT(sieve, 0.75 + search);
    }
}

// Uniform over the range, hence a third of the spread's square in the mean, and the stone has the
// proportions that were drawn.
TEST(Proportions, ScatterByTheSpread) {
  const StoneShape shape{.elongation = 0.7, .flatness = 0.6, .spread = 0.2};
  constexpr int count = 400;
  double mean = 0, square = 0, together = 0;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    const StoneShape own = proportions_of(shape, seed);
    const double e = own.elongation - 0.7, f = own.flatness - 0.6;
    EXPECT_LE(std::max(std::abs(e), std::abs(f)), 0.2);
    mean += e / count, square += e * e / count, together += e * f / count;
    if (seed < 5) expect_proportions(rounded_stone(shape, 0.05, seed), own);
  }
  const double variance = 0.04 / 3;
  EXPECT_NEAR(mean, 0, 4 * std::sqrt(variance / count));
  EXPECT_NEAR(square, variance, 0.2 * variance);  // 4 standard errors of an even distribution
  EXPECT_NEAR(together, 0, 4 * variance / std::sqrt(count));
}

TEST(Proportions, ThatAreImpossibleAreRefused) {
  try {
    rounded_stone({1, 1, 1, 6}, 0, 1);
    FAIL();
  } catch (const std::invalid_argument& why) {
    EXPECT_NE(std::string(why.what()).find("elongation of 1 and a flatness of 1"),
              std::string::npos);
  }
  EXPECT_THROW(rounded_stone({0.3, 0.2, 1, 24}, 0.2, 1), std::invalid_argument);  // S below 2 r
}

}  // namespace
}  // namespace trackbed::geom::proportions_test
