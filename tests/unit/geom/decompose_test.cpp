// Meshes cut into convex pieces, and filled with spheres.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "geom/mesh/part.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/geom/mesh.hpp"
#include "unit/geom/bodies.hpp"

namespace trackbed::geom::decompose_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-12;

TEST(Depths, OfACube) {
  const std::vector<Vec3> points{{0.5, 0.5, 0.5}, {0.1, 0.5, 0.5}, {-0.2, 0.5, 0.5}, {2, 2, 1}};
  const std::vector<double> found = depths(cube(), points);
  EXPECT_NEAR(found[0], 0.5, rounding);
  EXPECT_NEAR(found[1], 0.1, rounding);
  EXPECT_NEAR(found[2], -0.2, rounding);
  EXPECT_NEAR(found[3], -std::sqrt(2), rounding);
}

// A point in each place: within the core, near a face, an edge and a corner, and outside of each.
TEST(Depths, OfARoundedCube) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1, k >> 1 & 1, k >> 2);
  const Piece piece{convex_hull(corners), 0.5};
  const std::vector<Vec3> points{{0.5, 0.5, 0.5}, {0.5, 0.5, 1.2}, {0.5, 1.2, 1.2},
                                 {1.2, 1.2, 1.2}, {0.5, 1.4, 1.4}, {0.5, 0.5, 3}};
  const std::vector<double> wanted{
      1, 0.3, 0.5 - 0.2 * std::sqrt(2), 0.5 - 0.2 * std::sqrt(3), 0.5 - 0.4 * std::sqrt(2), -1.5};
  const std::vector<double> found = depths(piece, points);
  for (std::size_t k = 0; k < points.size(); ++k) EXPECT_NEAR(found[k], wanted[k], rounding) << k;
}

TEST(Depths, OfAStoneAreThoseOfItsSurface) {
  const Piece stone = rounded_stone({}, 0.1, 3);
  std::vector<Vec3> points;
  for (std::uint64_t k = 0; k < 2000; ++k)
    points.push_back(0.6 * Vec3(2 * uniform(1, 3 * k) - 1, 2 * uniform(1, 3 * k + 1) - 1,
                                2 * uniform(1, 3 * k + 2) - 1));
  constexpr int fineness = 12;
  const std::vector<double> exact = depths(stone, points),
                            mesh = depths(surface_of(stone, fineness), points);
  const double chord = stone.radius / (fineness * fineness);
  int inside = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (exact[k] < 0) {
      EXPECT_LT(mesh[k], 0) << k;
      continue;
    }
    EXPECT_NEAR(exact[k], mesh[k], chord) << k;
    ++inside;
  }
  EXPECT_GT(inside, 200);
}

TEST(ReducedHull, HasTheRequestedCornersAndStaysInside) {
  const Mesh sphere = ball_mesh();
  double before = 0;
  for (const int vertices : {4, 8, 16, 32, 64}) {
    const Convex core = reduced_hull(sphere.vertices, vertices);
    EXPECT_EQ(core.vertices.size(), static_cast<std::size_t>(vertices));
    const double volume = steiner_of(core).volume;
    EXPECT_GT(volume, before);
    EXPECT_LT(volume, 4 * pi / 3);
    before = volume;
  }
  EXPECT_GT(before, 0.85 * 4 * pi / 3);
  EXPECT_EQ(reduced_hull(cube().vertices, 24).vertices.size(), 8u);
}

constexpr double raster = 2e-3;  // of unions measured by lines

TEST(Decompose, AnLIsTwoBoxes) {
  const Decomposition one = decompose(letter(), 1, 24);
  ASSERT_EQ(one.pieces.size(), 1u);
  EXPECT_NEAR(one.volume_error, 7.0 / 5 - 1, rounding);  // the hull
  const Decomposition two = decompose(letter(), 8, 24);
  ASSERT_EQ(two.pieces.size(), 2u);  // both convex: the cutting stops
  EXPECT_NEAR(two.volume_error, 0, raster);
  double volume = 0;
  for (const Convex& piece : two.pieces) volume += steiner_of(piece).volume;
  EXPECT_NEAR(volume, 5, 1e-9);
}

TEST(Decompose, FewCornersKeepTheVolume) {
  const Decomposition ball = decompose(ball_mesh(), 1, 20);
  EXPECT_EQ(ball.pieces[0].vertices.size(), 20u);
  EXPECT_NEAR(ball.volume_error, 0, 1e-9);
}

TEST(Decompose, ConvexBodiesAreNotCut) {
  EXPECT_EQ(decompose(cube(), 8, 24).pieces.size(), 1u);
  EXPECT_EQ(decompose(ball_mesh(), 8, 1000).pieces.size(), 1u);
}

// Three planes that intersect inside the body make a corner that is on none of its triangles.
TEST(Decompose, FindsCornersInsideTheBody) {
  const Mesh body = cube();
  Part octant = whole_part(body);
  for (int k = 0; k < 3; ++k) octant = cut(octant, {Vec3::Unit(k), 0.75}, body).second;
  EXPECT_NEAR(octant.volume, 0.421875, rounding);  // 0.75^3
  EXPECT_NEAR(octant.hull_volume, 0.421875, rounding);
  EXPECT_EQ(octant.corners.size(), 8u);
}

Mesh bitten_ball() {
  Mesh body = surface_of(ball({0, 0, 0}, 1), 6);
  for (Vec3& p : body.vertices) p *= 1 - 0.6 * std::exp(-8 * (p - Vec3::UnitX()).squaredNorm());
  return body;
}

// Planes through edges made by earlier cuts: the side of their ends is determined by rounding,
// equally for the triangles on both sides. The areas of a closed surface add up to 0.
TEST(Decompose, PartsStayClosed) {
  // A corner of three planes that is on the surface to rounding may count as outside.
  constexpr double corner = 1e-5;  // of the volume
  const Mesh body = bitten_ball();
  Part part = whole_part(body);
  for (std::uint64_t k = 0; k < 40; ++k) {
    const auto pick = [&](const auto& list, std::uint64_t key) {
      return list[static_cast<std::size_t>(uniform(k, key) * static_cast<double>(list.size()))];
    };
    const auto edge = pick(part.caps.empty() ? part.skin : part.caps, 0);
    const Vec3 a = edge[1], b = edge[2], c = pick(part.corners, 1);
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-3) continue;
    auto [above, below] = cut(part, {normal.normalized(), normal.normalized().dot(a)}, body);
    for (const Part& side : {above, below}) {
      Vec3 area = Vec3::Zero();
      for (const auto* triangles : {&side.skin, &side.caps})
        for (const auto& [p, q, r] : *triangles) area += (q - p).cross(r - p);
      EXPECT_LT(area.norm(), rounding) << k;
      EXPECT_GT(side.concavity(), -corner * side.volume) << k;
    }
    EXPECT_NEAR(above.volume + below.volume, part.volume, rounding) << k;
    part = above.volume > below.volume ? std::move(above) : std::move(below);
  }
}

// Each rank decomposes for itself: the result must not depend on memory addresses.
TEST(Decompose, DoesNotDependOnAddresses) {
  const Mesh body = bitten_ball();
  const Decomposition made = decompose(body, 4, 1000);
  std::vector<std::unique_ptr<char[]>> blocks;
  for (std::uint64_t round = 0; round < 4; ++round) {
    for (std::uint64_t k = 0; k < 20000; ++k)
      blocks.push_back(std::make_unique<char[]>(16 + mix(round << 32 | k) % 300));
    for (std::uint64_t k = 0; k < blocks.size(); ++k)
      if (k % 4) blocks[k * 7919 % blocks.size()].reset();
    const Decomposition again = decompose(body, 4, 1000);
    ASSERT_EQ(again.pieces.size(), made.pieces.size());
    for (std::size_t p = 0; p < made.pieces.size(); ++p)
      EXPECT_EQ(again.pieces[p].vertices, made.pieces[p].vertices);
  }
}

TEST(Decompose, MorePartsComeNearer) {
  const Mesh body = bitten_ball();
  double before = 1e9;
  for (const int parts : {1, 2, 4, 8}) {
    const Decomposition made = decompose(body, parts, 1000);
    EXPECT_LE(made.pieces.size(), static_cast<std::size_t>(parts));
    EXPECT_GT(made.volume_error, -raster);
    EXPECT_LT(made.volume_error, before);
    before = made.volume_error;
  }
  EXPECT_LT(before, 0.02);
}

TEST(Clump, OfABallIsTheBall) {
  const Clump made = clump(ball_mesh(), 1);
  ASSERT_EQ(made.spheres.size(), 1u);
  EXPECT_NEAR(made.spheres[0].radius, 1, 0.01);  // the mesh is inside the ball
  EXPECT_LT(made.surface_furthest, 0.05);        // grid of a fortieth of the size
}

// The spheres of a stone and those of a mesh of its surface differ as mesh and stone do.
TEST(Clump, OfAStoneHasItsVolume) {
  const Piece stone = rounded_stone({}, 0.05, 7);
  const std::vector<Sphere> spheres = spheres_filling(stone, 8);
  ASSERT_EQ(spheres.size(), 8u);
  const double volume = piece_solid(stone).volume;
  EXPECT_NEAR(union_volume(spheres, 400) / volume, 1, raster);
  const std::vector<Sphere> of_mesh = clump(surface_of(stone), 8).spheres;
  EXPECT_NEAR(of_mesh[0].radius, spheres[0].radius, 0.01 * spheres[0].radius);
}

TEST(Clump, MoreSpheresComeNearer) {
  double before = 1e9;
  for (const int spheres : {2, 8, 32}) {
    const Clump made = clump(letter(), spheres);
    EXPECT_EQ(made.spheres.size(), static_cast<std::size_t>(spheres));
    EXPECT_NEAR(made.volume_error, 0, raster);
    EXPECT_LT(made.surface_error, before);
    EXPECT_GE(made.surface_furthest, made.surface_error);
    before = made.surface_error;
  }
  EXPECT_LT(before, 0.06);  // m, of legs 1 m thick
}

}  // namespace
}  // namespace trackbed::geom::decompose_test
