// Shapes of stones against closed forms.
#include "trackbed/geom/stone.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace trackbed::geom::stone_test {
namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;
constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-13;  // a few dozen operations on numbers of order 1

Polygon rectangle(double w, double h, Point at, double angle) {
  Polygon p;
  const Eigen::Rotation2Dd turn(angle);
  for (const Point& c : {Point(-w, -h), Point(w, -h), Point(w, h), Point(-w, h)})
    p.push_back(at + turn * (c / 2));
  return p;
}

Polygon regular(int corners) {
  Polygon p;
  for (int k = 0; k < corners; ++k)
    p.emplace_back(std::cos(2 * pi * k / corners), std::sin(2 * pi * k / corners));
  return p;
}

TEST(Polygon, Rectangle) {
  const double w = 2, h = 0.5, angle = 0.4;
  const Polygon p = rectangle(w, h, {3, -1}, angle);
  const Solid s = polygon_solid(p);
  EXPECT_NEAR(s.volume, w * h, rounding);
  EXPECT_NEAR((s.centre - Vec3(3, 0, -1)).norm(), 0, rounding);
  // Cancellation against the distance to the origin costs a digit or two.
  EXPECT_NEAR(s.gyration.y(), (w * w + h * h) / 12, 100 * rounding);
  EXPECT_NEAR(s.gyration.x(), h * h / 12, 100 * rounding);
  EXPECT_NEAR(s.gyration.z(), w * w / 12, 100 * rounding);
  const Vec3 along = s.axes * Vec3::UnitX();  // principal x: the long side
  EXPECT_NEAR(std::abs(along.dot(Vec3(std::cos(angle), 0, std::sin(angle)))), 1, 100 * rounding);
  EXPECT_NEAR(smallest_width(p), h, rounding);
}

TEST(Polygon, RegularOfAnyNumberOfCorners) {
  for (int n = 3; n < 12; ++n) {
    const Solid s = polygon_solid(regular(n));
    EXPECT_NEAR(s.volume, n * std::sin(2 * pi / n) / 2, rounding);
    EXPECT_NEAR(s.gyration.y(), (2 + std::cos(2 * pi / n)) / 6, rounding);
    const double width = n % 2 == 0 ? 2 * std::cos(pi / n) : 1 + std::cos(pi / n);
    EXPECT_NEAR(smallest_width(regular(n)), width, rounding);
  }
}

TEST(Outline, HasTheWantedProportionsAndRepeats) {
  for (const double elongation : {0.4, 0.6, 0.75, 0.85})
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const OutlineShape shape{elongation, 0.5, 12};
      const Polygon p = outline(shape, seed);
      double extent = 0;
      for (const Point& a : p)
        for (const Point& b : p) extent = std::max(extent, (a - b).norm());
      EXPECT_NEAR(extent, 1, rounding);
      // The iteration stops at 1e-12; twelve scattered corners cannot always approximate a circle.
      const double reached = elongation < 0.8 ? 1e-9 : 0.08;
      EXPECT_NEAR(smallest_width(p), elongation, reached) << seed;
      EXPECT_LT(polygon_solid(p).centre.norm(), rounding);
      EXPECT_GT(polygon_solid(p).volume, 0);  // counter-clockwise
      EXPECT_EQ(p, outline(shape, seed));
      EXPECT_NE(p, outline(shape, seed + 100));
    }
}

TEST(Outline, SmoothOneFillsItsEllipse) {
  const OutlineShape smooth{0.7, 0, 64}, rough{0.7, 1, 64};
  // 64 corners on an ellipse: its area up to (2 pi/64)^2/6 = 0.16 %.
  EXPECT_NEAR(polygon_solid(outline(smooth, 1)).volume, pi / 4 * 0.7, 0.005 * pi / 4 * 0.7);
  EXPECT_EQ(outline(smooth, 1).size(), 64u);
  EXPECT_LT(outline(rough, 1).size(), 48u);  // scatter hides corners inside the hull
}

TEST(Pebbles, StayInsideTouchTheBorderAndLeaveNoGap) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Polygon p = outline({0.7, 0.5, 12}, seed);
    constexpr double radius = 0.1, spacing = 2;
    const auto pebbles = pebbles_inside(p, radius, spacing);
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Point edge = (p[(i + 1) % p.size()] - p[i]).normalized(), inward(-edge.y(), edge.x());
      double nearest = 1;
      for (const Sphere& s : pebbles)
        nearest = std::min(nearest, inward.dot(Point(s.centre.x(), s.centre.z()) - p[i]));
      EXPECT_GT(nearest, radius - rounding);
      if ((p[(i + 1) % p.size()] - p[i]).norm() > 2 * radius) {
        EXPECT_LT(nearest, 1.4 * radius);  // corners closer than 0.4 radii share a disk
      }
    }
    // All around: seen from the centroid no two neighbours are further apart than the spacing.
    double widest = 0;
    for (std::size_t k = 0; k < pebbles.size(); ++k)
      widest =
          std::max(widest, (pebbles[(k + 1) % pebbles.size()].centre - pebbles[k].centre).norm());
    EXPECT_LT(widest, spacing * radius * (1 + rounding));
    EXPECT_GT(widest, 0.5 * spacing * radius);
  }
}

TEST(Pebbles, FollowTheSpacing) {
  const Polygon box = rectangle(1, 1, {0, 0}, 0);
  EXPECT_EQ(pebbles_inside(box, 0.25, 2).size(), 4u);      // ring of side 0.5
  EXPECT_EQ(pebbles_inside(box, 0.125, 2).size(), 12u);    // of side 0.75: 3 gaps of 0.25
  EXPECT_EQ(pebbles_inside(box, 0.125, 1.5).size(), 16u);  // 4 gaps of at most 0.1875
  EXPECT_THROW(pebbles_inside(box, 0.51, 2), std::invalid_argument);
}

TEST(Union, SingleSphere) {
  const double r = 0.3;
  const Solid s = union_solid({{Vec3(1, -2, 0.5), r}}, 96);
  const double volume = 4 * pi / 3 * r * r * r;
  constexpr double raster = 2e-3;  // 96^-3/2 = 1.06e-3, twice
  EXPECT_NEAR(s.volume, volume, raster * volume);
  EXPECT_NEAR((s.centre - Vec3(1, -2, 0.5)).norm(), 0, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(s.gyration[k], 0.4 * r * r, raster * r * r);
}

TEST(Union, DisjointAndOverlappingSpheres) {
  constexpr double raster = 2e-3;
  const Vec3 along = Vec3(1, 2, 2).normalized();
  const Solid apart = union_solid({{along, 0.4}, {-along, 0.4}}, 192);
  const double one = 4 * pi / 3 * 0.064, about = 0.4 * 0.16;
  EXPECT_NEAR(apart.volume, 2 * one, raster * 2 * one);
  EXPECT_NEAR(apart.gyration[0], about, raster * 1.1);  // ascending: the axis of the pair first
  EXPECT_NEAR(apart.gyration[1], 1 + about, raster * 1.1);
  EXPECT_NEAR(apart.gyration[2], 1 + about, raster * 1.1);
  EXPECT_NEAR(std::abs((apart.axes * Vec3::UnitX()).dot(along)), 1, 1e-4);
  // Two unit spheres at distance d share a lens of volume pi (4 + d)(2 - d)^2/12.
  const double d = 0.8, lens = pi * (4 + d) * (2 - d) * (2 - d) / 12;
  const Solid both = union_solid({{Vec3(0, 0, 0), 1}, {Vec3(0, d, 0), 1}}, 192);
  EXPECT_NEAR(both.volume, 8 * pi / 3 - lens, raster * 8 * pi / 3);
  // A sphere within another, or given twice, counts once.
  const Solid same =
      union_solid({{Vec3::Zero(), 1}, {Vec3::Zero(), 1}, {Vec3(0.1, 0, 0), 0.5}}, 48);
  EXPECT_EQ(same.volume, union_solid({{Vec3::Zero(), 1}}, 48).volume);
}

TEST(Union, ConvergesWithTheCells) {
  const double exact = 4 * pi / 3;
  double coarse = 0, fine = 0;  // means over several rasters: a single error may vanish by chance
  for (int k = 0; k < 8; ++k) {
    coarse += std::abs(union_solid({{Vec3::Zero(), 1}}, 20 + k).volume - exact);
    fine += std::abs(union_solid({{Vec3::Zero(), 1}}, 4 * (20 + k)).volume - exact);
  }
  const double order = std::log(coarse / fine) / std::log(4.0);
  EXPECT_GT(order, 1.4);  // 3/2 at least; smooth cancellation along the rim may add to it
  EXPECT_LT(order, 3.0);
}

TEST(Union, Lamina) {
  const double r = 0.3, d = 1;
  const Solid one = union_lamina({{Vec3(1, 0.2, 2), r}});
  constexpr double raster = 1e-5;  // 4096^-3/2 = 4e-6
  EXPECT_NEAR(one.volume, pi * r * r, raster * pi * r * r);
  EXPECT_NEAR(one.gyration.y(), r * r / 2, raster * r * r);
  EXPECT_NEAR((one.centre - Vec3(1, 0, 2)).norm(), 0, 1e-12);
  const Solid two = union_lamina({{Vec3(0, 0, 0), r}, {Vec3(d, 0, 0), r}});
  EXPECT_NEAR(two.gyration.y(), r * r / 2 + d * d / 4, raster);
}

// A clump in the plane has the mass of its disks: there is none in its hollow.
TEST(Union, PointsOfAClumpLieInItsDisks) {
  constexpr int count = 512;
  std::vector<Sphere> disks;
  for (int k = 0; k < 7; ++k)  // three quarters of a ring
    disks.push_back({Vec3(std::cos(k * pi / 4), 0, std::sin(k * pi / 4)), 0.5});
  std::vector<Piece> pieces;
  for (const Sphere& d : disks) pieces.push_back(ball(d.centre, d.radius));
  const Template shape = template_of(pieces, union_lamina(disks), 1);
  const std::vector<Vec3> points = points_within(shape, count, true);
  ASSERT_EQ(points.size(), static_cast<std::size_t>(count));
  int outside = 0;
  for (const Vec3& p : points) {
    double nearest = 10;
    for (const Piece& piece : shape.pieces)
      nearest = std::min(nearest, (p - piece.core.vertices[0]).norm());
    outside += nearest > 0.5;
    EXPECT_LT(nearest, 0.5 + 3.0 / 64);  // a cell of the raster: length of the stone over 64
  }
  EXPECT_LT(outside, count / 50);
}

}  // namespace
}  // namespace trackbed::geom::stone_test
