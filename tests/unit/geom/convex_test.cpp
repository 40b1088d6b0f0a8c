// Hulls and rounded solids against closed forms.
#include "trackbed/geom/convex.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom::convex_test {
namespace {

using Points = std::vector<Vec3>;
constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-12;  // some hundred operations on numbers of order 1

Points box(const Vec3& size) {
  Points p;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) p.push_back(size.cwiseProduct(Vec3(x, y, z)));
  return p;
}

Points moved(Points points, const Quat& turn, const Vec3& shift) {
  for (Vec3& p : points) p = turn * p + shift;
  return points;
}

Points random_points(int count, std::uint64_t seed) {
  Points points;
  for (int k = 0; k < count; ++k) {
    const auto key = static_cast<std::uint64_t>(3 * k);
    points.emplace_back(uniform(seed, key), uniform(seed, key + 1), uniform(seed, key + 2));
  }
  return points;
}

const Quat oblique(Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()));

TEST(Hull, BoxHasSixFacesInAnyAttitude) {
  Points points = moved(box({2, 3, 5}), oblique, {100, -20, 3});
  points.push_back(points[0]);                    // twice
  points.push_back((points[0] + points[1]) / 2);  // within an edge
  points.push_back((points[0] + points[3]) / 2);  // within a face
  points.push_back((points[0] + points[7]) / 2);  // inside
  const Convex core = convex_hull(points);
  EXPECT_EQ(core.vertices.size(), 8u);
  EXPECT_EQ(core.edges.size(), 12u);
  ASSERT_EQ(core.faces.size(), 6u);
  for (const Face& face : core.faces) {
    EXPECT_EQ(face.vertices.size(), 4u);
    EXPECT_NEAR(face.normal.norm(), 1, rounding);
  }
  for (const Edge& edge : core.edges)
    EXPECT_NEAR(core.faces[static_cast<std::size_t>(edge.faces[0])].normal.dot(
                    core.faces[static_cast<std::size_t>(edge.faces[1])].normal),
                0, rounding);
}

// Points scattered over the faces and edges of a box are off them by rounding errors.
TEST(Hull, ToleratesRoundingErrors) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Points points = box(Vec3::Ones());
    for (Vec3 p : random_points(100, seed)) {
      const auto k = static_cast<int>(3 * p.x());
      p[k] = p[k] < 0.5 ? 0 : 1;
      if (p[(k + 1) % 3] < 0.3) p[(k + 1) % 3] = 0;
      points.push_back(p - Vec3::Constant(0.5));
    }
    const Quat turn = Quat(Eigen::AngleAxisd(static_cast<double>(seed), points[20].normalized()));
    const Convex core = convex_hull(moved(points, turn, 10 * points[30]));
    EXPECT_EQ(core.vertices.size(), 8u) << seed;
    EXPECT_EQ(core.edges.size(), 12u) << seed;
    EXPECT_EQ(core.faces.size(), 6u) << seed;
  }
}

TEST(Hull, KeepsAllPointsInsideAndItsOwnCorners) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const double size = std::pow(10.0, static_cast<double>(seed % 9) - 4);  // no tolerance is in m
    Points points = random_points(4 + static_cast<int>(seed) * 2, seed);
    for (Vec3& p : points) p *= size;
    const Convex core = convex_hull(points);
    for (const Face& face : core.faces)
      for (const Vec3& p : points) EXPECT_LE(face.normal.dot(p), face.offset + 1e-14 * size);
    const Convex again = convex_hull(core.vertices);
    EXPECT_EQ(again.vertices, core.vertices);
    EXPECT_EQ(again.faces.size(), core.faces.size());
    EXPECT_EQ(core.vertices.size() + core.faces.size(), core.edges.size() + 2);
  }
}

TEST(Hull, FlatAndThinOnes) {
  EXPECT_EQ(convex_hull({Vec3(1, 2, 3), Vec3(1, 2, 3)}).vertices, Points{Vec3(1, 2, 3)});
  const Convex segment =
      convex_hull(moved({{0, 0, 0}, {1, 0, 0}, {0.3, 0, 0}}, oblique, {1, 1, 1}));
  EXPECT_EQ(segment.vertices.size(), 2u);
  ASSERT_EQ(segment.edges.size(), 1u);
  EXPECT_EQ(segment.edges[0].faces[0], -1);
  const Convex plate = convex_hull(moved(box({2, 3, 0}), oblique, {1, 1, 1}));
  EXPECT_EQ(plate.vertices.size(), 4u);
  EXPECT_EQ(plate.edges.size(), 4u);
  ASSERT_EQ(plate.faces.size(), 2u);
  EXPECT_NEAR(plate.faces[0].normal.dot(plate.faces[1].normal), -1, rounding);
}

TEST(Hull, RefusesInvalidPoints) {
  EXPECT_THROW(convex_hull({}), std::invalid_argument);
  EXPECT_THROW(convex_hull({Vec3(0, 0, std::numeric_limits<double>::quiet_NaN())}),
               std::invalid_argument);
  const Convex cube = convex_hull(box({1, 1, 1}));
  std::vector<std::vector<int>> faces;
  for (const Face& face : cube.faces) faces.push_back(face.vertices);
  EXPECT_EQ(convex_of(cube.vertices, faces).edges.size(), 12u);
  auto broken = faces;
  broken.pop_back();
  EXPECT_THROW(convex_of(cube.vertices, broken), std::invalid_argument);  // open
  broken = faces;
  std::reverse(broken[2].begin(), broken[2].end());
  EXPECT_THROW(convex_of(cube.vertices, broken), std::invalid_argument);  // inside out
  broken = faces;
  broken[0][0] = 8;
  EXPECT_THROW(convex_of(cube.vertices, broken), std::invalid_argument);  // no such corner
  Points dented = cube.vertices;
  dented[7] *= 0.5;
  EXPECT_THROW(convex_of(dented, faces), std::invalid_argument);
  EXPECT_THROW(convex_of(cube.vertices, {}), std::invalid_argument);
}

TEST(Rounded, TetrahedronWithoutRounding) {
  const Solid s = piece_solid({convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), 0});
  EXPECT_NEAR(s.volume, 1.0 / 6, rounding);
  EXPECT_NEAR((s.centre - Vec3::Constant(0.25)).norm(), 0, rounding);
  // Covariance 3/80 on and -1/80 off the diagonal.
  EXPECT_NEAR(s.gyration[0], 4.0 / 80 + 1.0 / 80, rounding);
  EXPECT_NEAR(s.gyration[2], 8.0 / 80, rounding);
}

// Volume, area and moment of a box with rounded edges, from its parts by hand.
TEST(Rounded, Box) {
  const Vec3 size(2, 3, 5);
  const double r = 0.4;
  const Piece piece{convex_hull(moved(box(size), oblique, {7, -3, 2})), r};
  const Solid s = piece_solid(piece);
  const double a = size.x(), b = size.y(), c = size.z();
  const double volume = a * b * c + 2 * r * (a * b + b * c + c * a) + pi * r * r * (a + b + c) +
                        4 * pi / 3 * r * r * r;
  EXPECT_NEAR(s.volume, volume, 1e-11 * volume);
  EXPECT_NEAR(surface_area(piece),
              2 * (a * b + b * c + c * a) + 2 * pi * r * (a + b + c) + 4 * pi * r * r, 1e-10);
  EXPECT_NEAR((s.centre - Vec3(7, -3, 2)).norm(), 0, rounding);
  // Integral of x^2: slabs in x of constant section, and the two rounded ends, where it is a
  // rounded rectangle of radius rho = sqrt(r^2 - t^2) at x = a/2 + t.
  const auto square = [&](double along, double p, double q) {
    const double inner = along * along * along / 12 * (p * q + 2 * r * (p + q) + pi * r * r);
    double ends = 0;
    constexpr int parts = 200000;
    for (int k = 0; k < parts; ++k) {
      const double t = r * (k + 0.5) / parts, rho = std::sqrt(r * r - t * t);
      ends += 2 * r / parts * (along / 2 + t) * (along / 2 + t) *
              (p * q + 2 * rho * (p + q) + pi * rho * rho);
    }
    return inner + ends;
  };
  const double xx = square(a, b, c), yy = square(b, c, a), zz = square(c, a, b);
  constexpr double quadrature = 1e-6;
  EXPECT_NEAR(s.gyration[2], (yy + zz) / volume, quadrature);  // about the shortest side
  EXPECT_NEAR(s.gyration[1], (xx + zz) / volume, quadrature);
  EXPECT_NEAR(s.gyration[0], (xx + yy) / volume, quadrature);
}

TEST(Rounded, BallCapsuleAndPlate) {
  const double r = 0.7, l = 2;
  const Solid sphere = piece_solid(ball({1, 2, 3}, r));
  EXPECT_NEAR(sphere.volume, 4 * pi / 3 * r * r * r, rounding);
  EXPECT_NEAR((sphere.gyration - Vec3::Constant(0.4 * r * r)).norm(), 0, rounding);
  EXPECT_NEAR(surface_area(ball({1, 2, 3}, r)), 4 * pi * r * r, rounding);
  const Solid capsule = piece_solid({convex_hull({{0, 0, 0}, {0, l, 0}}), r});
  const double tube = pi * r * r * l, caps = 4 * pi / 3 * r * r * r;
  EXPECT_NEAR(capsule.volume, tube + caps, rounding);
  EXPECT_NEAR(capsule.gyration[0], (tube * r * r / 2 + caps * 0.4 * r * r) / (tube + caps),
              rounding);  // about the axis
  EXPECT_NEAR((capsule.centre - Vec3(0, l / 2, 0)).norm(), 0, rounding);
  const Piece plate{convex_hull({{0, 0, 0}, {1, 0, 0}, {1, 0, 2}, {0, 0, 2}}), r};
  EXPECT_NEAR(piece_solid(plate).volume, 2 * 2 * r + pi * r * r * 3 + caps, rounding);
}

// The rounded solid of a ball with many corners is nearly the ball of the larger radius; the sum of
// the exact parts must also agree with a raster of lines.
TEST(Rounded, AgreesWithTheRasterOfLines) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Piece piece{convex_hull(random_points(14, seed)), 0.15};
    const Solid exact = piece_solid(piece), raster = union_solid(std::vector{piece}, 192);
    constexpr double cells = 5e-4;  // 192^-3/2 = 3.8e-4
    EXPECT_NEAR(raster.volume, exact.volume, cells * exact.volume);
    EXPECT_NEAR((raster.centre - exact.centre).norm(), 0, cells);
    EXPECT_NEAR((raster.gyration - exact.gyration).norm(), 0, 2 * cells);
  }
}

// An L of two boxes that overlap in a corner block: the overlap counts once.
TEST(Rounded, CompoundOfOverlappingBoxes) {
  const Piece lying{convex_hull(moved(box({3, 1, 1}), Quat::Identity(), {1.5, 0.5, 0.5})), 0};
  const Piece standing{convex_hull(moved(box({1, 1, 3}), Quat::Identity(), {0.5, 0.5, 1.5})), 0};
  const Solid s = union_solid(std::vector{lying, standing}, 192);
  constexpr double cells = 1e-3;  // the faces coincide with the raster's lines to a cell
  EXPECT_NEAR(s.volume, 5, 5 * cells);
  EXPECT_NEAR((s.centre - Vec3(1.1, 0.5, 1.1)).norm(), 0, cells);
  // About y: x^2 + z^2 by blocks, less the centre's.
  const double square = (27.0 / 3 + 2 * 1.0 / 3) + (27.0 / 3 + 2 * 1.0 / 3);
  EXPECT_NEAR(s.gyration[2], square / 5 - 2 * 1.21, 5 * cells);
  EXPECT_NEAR(union_area({lying, standing}), 22, 0.01 * 22);
  EXPECT_NEAR(union_area({ball({1, 2, 3}, 0.7), ball({1, 2, 3}, 0.5)}), 4 * pi * 0.49, 0.01 * 6.16);
}

}  // namespace
}  // namespace trackbed::geom::convex_test
