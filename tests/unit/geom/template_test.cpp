// Openings, rounding, templates and parametric stones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom::template_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-12;

Convex box(const Vec3& size) {
  std::vector<Vec3> p;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) p.push_back(size.cwiseProduct(Vec3(x, y, z)));
  return convex_hull(p);
}

const Quat oblique(Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()));

TEST(Openings, HoleAndSlotOfSpheres) {
  // End to end 3, thickness 2: slot 2; the pair passes the hole of one sphere lengthwise.
  const std::vector<Sphere> pair{{Vec3(0, 0, 0), 1}, {Vec3(0.6, 0, 0.8), 1}};
  EXPECT_NEAR(smallest_slot(pair), 2, 0.01);
  constexpr double search = 1e-6;
  EXPECT_NEAR(smallest_hole(pair), 2, search);
  const std::vector<Sphere> three{{Vec3(0, 0, 0), 1}, {Vec3(1, 0, 0), 1}, {Vec3(0, 2, 0), 1}};
  // Along its longest side, of sqrt(5), the projection of the flat triangle has its height
  // 2/sqrt(5) on the diagonal of the square.
  EXPECT_NEAR(smallest_hole(three), 2 + 2 / std::sqrt(10.0), search);
  EXPECT_NEAR(smallest_slot({{Vec3(1, 0, 3), 0.25}}), 0.5, rounding);
}

TEST(Openings, HoleOfStones) {
  constexpr double search = 1e-6;
  const auto hole = [](const Convex& core, double r) {
    return smallest_hole(std::vector<Piece>{{moved(core, oblique, Vec3(3, 2, 1)), r}});
  };
  EXPECT_NEAR(hole(box({1, 1, 1}), 0), 1, search);
  EXPECT_NEAR(hole(box({3, 2, 1.9}), 0), 2, search);
  EXPECT_NEAR(hole(box({3, 2, 1.9}), 0.1), 2.2, search);
  // A thin plate passes through the diagonal.
  EXPECT_NEAR(hole(box({3, 2, 0.1}), 0), 2.1 / std::sqrt(2.0), search);
}

// A body whose best direction is at a kink, where only few rotations reduce its square. The hole is
// the best of 20 searches by random rotations; a search with rotations to one side of a diagonal
// stops 8e-4 above it.
TEST(Openings, HoleAtAKink) {
  std::vector<Sphere> corners;
  for (const Vec3& p : {Vec3(-0.1, 0.4, -0.6), Vec3(0, -0.2, -0.6), Vec3(0, 0.6, -0.8),
                        Vec3(-0.4, 0.3, 0.1), Vec3(0.2, 0.5, 0.4), Vec3(0.1, 0.1, -0.6)})
    corners.push_back({p, 0});
  constexpr double hole = 0.576909, search = 2e-4;  // 26 rotations stop 9e-5 above it
  EXPECT_GT(smallest_hole(corners), (1 - search) * hole);
  EXPECT_LT(smallest_hole(corners), (1 + search) * hole);
}

TEST(Rounding, KeepsTheVolume) {
  const Convex cube = box({2, 3, 4});
  for (const double r : {0.0, 0.01, 0.3, 1.5}) {
    const Piece piece = rounded(cube, r);
    EXPECT_EQ(piece.radius, r);
    EXPECT_NEAR(piece_solid(piece).volume, 24, 1e-11 * 24);
    EXPECT_EQ(piece.core.vertices.size(), 8u);
  }
  EXPECT_THROW(rounded(cube, std::cbrt(18 / pi) + 1e-9), std::invalid_argument);
}

TEST(Slices, FillTheCoreInEqualParts) {
  const Convex core = stone({.vertices = 16}, 3);
  const double volume = steiner_of(core).volume;
  for (const int parts : {1, 2, 3, 7}) {
    const std::vector<Convex> made = sliced(core, parts);
    ASSERT_EQ(made.size(), static_cast<std::size_t>(parts));
    double sum = 0;
    for (const Convex& part : made) {
      EXPECT_NEAR(steiner_of(part).volume, volume / parts, 1e-9 * volume);
      sum += steiner_of(part).volume;
      for (const Vec3& corner : part.vertices)
        for (const Face& face : core.faces) EXPECT_LT(face.normal.dot(corner), face.offset + 1e-12);
    }
    EXPECT_NEAR(sum, volume, 1e-12 * volume);
  }
  const Convex flat = convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  EXPECT_EQ(sliced(flat, 1).size(), 1u);
  EXPECT_THROW(sliced(flat, 2), std::invalid_argument);
  EXPECT_THROW(sliced(core, 0), std::invalid_argument);
}

TEST(Templates, ArePrincipalAxesAboutTheCentreOfMass) {
  const Vec3 size(1, 2, 3);
  const Template t = template_of({{moved(box(size), oblique, {5, 6, 7}), 0}});
  EXPECT_NEAR(t.volume, 6, 1e-11);
  EXPECT_NEAR(t.gyration[0], (1 + 4) / 12.0, 1e-11);
  EXPECT_NEAR(t.gyration[1], (1 + 9) / 12.0, 1e-11);
  EXPECT_NEAR(t.gyration[2], (4 + 9) / 12.0, 1e-11);
  EXPECT_NEAR(t.sieve, 2, 1e-6);
  EXPECT_NEAR(bounding_radius(t), std::sqrt(14) / 2, 1e-11);
  for (const Vec3& corner : t.pieces[0].core.vertices)  // gyration ascends: extents descend
    EXPECT_NEAR((corner.cwiseAbs() - Vec3(1.5, 1, 0.5)).norm(), 0, 1e-11);
  for (const Face& face : t.pieces[0].core.faces)
    for (const int v : face.vertices)
      EXPECT_NEAR(face.normal.dot(t.pieces[0].core.vertices[static_cast<std::size_t>(v)]),
                  face.offset, 1e-11);
}

TEST(Stone, HasTheRequestedCorners) {
  for (const int vertices : {6, 12, 24, 60, 200})
    for (const double angularity : {0.0, 0.5, 1.0})
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const StoneShape shape{0.8, 0.6, angularity, vertices};
        const Convex core = stone(shape, seed);
        ASSERT_EQ(core.vertices.size(), static_cast<std::size_t>(vertices));
        EXPECT_EQ(core.faces.size(), core.vertices.size() * 2 - 4);  // triangles
        EXPECT_NEAR(piece_solid({core, 0}).centre.norm(), 0, rounding);
        EXPECT_EQ(core.vertices, stone(shape, seed).vertices);
        EXPECT_NE(core.vertices, stone(shape, seed + 100).vertices);
      }
}

TEST(Stone, SmoothOneIsAnEllipsoid) {
  const Convex core = stone({0.7, 0.8, 0, 200}, 1);
  // The hull of 200 evenly spread points in a ball has 3 % less volume. Its smallest widths, which
  // are stretched to the required ones, are up to 2 % below the diameter.
  const double volume = pi / 6 * 0.7 * 0.7 * 0.8;
  EXPECT_NEAR(steiner_of(core).volume, volume, 0.03 * volume);
}

struct Statistics {
  double mean = 0, spread = 0;
};

Statistics statistics(const std::vector<double>& values) {
  Statistics s;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) s.mean += v / n;
  for (const double v : values) s.spread += (v - s.mean) * (v - s.mean) / (n - 1);
  s.spread = std::sqrt(s.spread);
  return s;
}

// Ten scanned ballast stones (HRSBallast, CC0): box as scanned, mm; volume, cm3; area, cm2.
constexpr double scans[10][5] = {
    {61.6, 62.5, 56.9, 66.37, 101.1},  {66.5, 60.3, 68.8, 39.63, 84.1},
    {77.5, 66.5, 52.6, 51.16, 93.8},   {67.0, 69.9, 72.4, 90.54, 121.8},
    {66.0, 61.8, 75.0, 79.86, 117.3},  {71.1, 87.8, 67.0, 115.67, 149.2},
    {66.8, 87.2, 85.0, 126.79, 151.4}, {57.7, 86.2, 91.8, 149.07, 169.2},
    {82.5, 85.7, 87.7, 163.83, 185.7}, {81.8, 79.1, 80.5, 132.08, 162.3}};

struct Measures {
  std::vector<double> sphericity, fill, ratio;
};

Measures of_scans() {
  Measures m;
  for (const auto& [x, y, z, volume, area] : scans) {
    m.sphericity.push_back(sphericity(volume, area));
    m.fill.push_back(1e3 * volume / (x * y * z));
    m.ratio.push_back(std::min({x, y, z}) / std::max({x, y, z}));
  }
  return m;
}

// A stone has a random attitude on the scanner: boxes are those of stones in random attitudes.
Measures of_stones(const StoneShape& shape, double rounding) {
  Measures m;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Piece worn = rounded_stone(shape, rounding, seed);
    const double volume = piece_solid(worn).volume;
    Quat turn(uniform(seed, 1) - 0.5, uniform(seed, 2) - 0.5, uniform(seed, 3) - 0.5,
              uniform(seed, 4) - 0.5);
    turn.normalize();
    Vec3 low = Vec3::Constant(9), high = -low;
    for (const Vec3& p : worn.core.vertices)
      low = low.cwiseMin(turn * p), high = high.cwiseMax(turn * p);
    const Vec3 size = high - low + Vec3::Constant(2 * worn.radius);
    m.sphericity.push_back(sphericity(volume, surface_area(worn)));
    m.fill.push_back(volume / size.prod());
    m.ratio.push_back(size.minCoeff() / size.maxCoeff());
  }
  return m;
}

// The mean of ten scans is known to its standard error, their spread to about a quarter.
void compare(const char* name, const std::vector<double>& own, const std::vector<double>& scan,
             double errors) {
  const Statistics a = statistics(own), b = statistics(scan);
  std::printf("%s: %.3f +- %.3f, scanned %.3f +- %.3f\n", name, a.mean, a.spread, b.mean, b.spread);
  EXPECT_NEAR(a.mean, b.mean, errors * b.spread / std::sqrt(10)) << name;
  EXPECT_NEAR(a.spread / b.spread, 1, 0.3) << name;
}

// Sharp, and rounded as by `trackbed shapes` and in beds; fewer corners compensate for rounding.
// Scans differ in their proportions, so these scatter, too.
TEST(Stone, ReachesTheStatisticsOfScannedOnes) {
  const Measures scan = of_scans();
  for (const auto& [vertices, rounding] : {std::pair{24, 0.0}, {16, 0.02}, {12, 0.05}}) {
    StoneShape shape;
    shape.vertices = vertices;
    shape.spread = 0.23;
    std::printf("%d corners, rounding %g\n", vertices, rounding);
    const Measures own = of_stones(shape, rounding);
    compare("sphericity", own.sphericity, scan.sphericity, 1);
    compare("volume over box", own.fill, scan.fill, 1);
    // Boxes of the scans are nearer to cubes than those of stones of this sphericity in random
    // attitudes, so the attitudes were not random: within three standard errors.
    compare("least over largest side of the box", own.ratio, scan.ratio, 3);
  }
}

}  // namespace
}  // namespace trackbed::geom::template_test
