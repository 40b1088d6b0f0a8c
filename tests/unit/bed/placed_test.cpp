// Shapes, plates and boxes that a deck places.
#include "trackbed/bed/placed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace trackbed::placed_test {
namespace {

constexpr double pi = std::numbers::pi;

dem::Physics steel() {
  dem::Physics physics;
  physics.materials.resize(2);
  physics.materials[1].name = "steel";
  return physics;
}

Vec3 area_of(const Surface& s, const std::array<std::int32_t, 3>& t) {
  const auto at = [&](int k) {
    return s.position[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
  };
  return (at(1) - at(0)).cross(at(2) - at(0)) / 2;
}

// m^3, positive if normals point out of what the triangles enclose.
double enclosed(const Surface& s) {
  double volume = 0;
  for (const auto& t : s.triangles)
    volume += s.position[static_cast<std::size_t>(t[0])].dot(area_of(s, t)) / 3;
  return volume;
}

TEST(PlacedPlate, HasThePositionAndNormalOfTheDeck) {
  for (const std::vector<double>& normal :
       {std::vector<double>{0, 0, 1}, {0, 0, -2}, {1, 0, 0}, {0.3, -0.4, 0.5}}) {
    bed::PlateParameters p{.name = "p", .material = "steel", .centre = {1, 2, 3}, .normal = normal};
    p.size = {0.4, 0.2}, p.velocity = {1, 0, -2};
    bed::PlacedSurfaces placed({p}, {}, steel(), Dimension::space, 1);
    placed.update(2, 0.5);
    const Surface& s = placed.surfaces()[0];
    const Vec3 n = bed::vector_of(normal).normalized();
    Vec3 centre = Vec3::Zero();
    for (const Vec3& node : s.position) centre += node / 4;
    EXPECT_LT((centre - Vec3(3, 2, -1)).norm(), 1e-14);
    for (const auto& t : s.triangles) EXPECT_LT((area_of(s, t) - 0.04 * n).norm(), 1e-15);
    for (const Vec3& increment : s.motion) EXPECT_EQ(increment, Vec3(0.5, 0, -1));
    EXPECT_NEAR((s.position[1] - s.position[0]).norm(), 0.4, 1e-14);
    EXPECT_EQ(s.material, 1);
  }
}

TEST(PlacedPlate, ExtendsAcrossAPlaneModel) {
  const bed::PlateParameters p{.name = "p", .material = "steel", .normal = {-1, 0, 1}};
  const bed::PlacedSurfaces placed({p}, {}, steel(), Dimension::plane, 0.3);
  const Surface& s = placed.surfaces()[0];
  for (const auto& t : s.triangles)
    EXPECT_GT(area_of(s, t).normalized().dot(Vec3(-1, 0, 1).normalized()), 1 - 1e-14);
  for (const Vec3& node : s.position) EXPECT_GT(std::abs(node.y()), 0.15);
}

TEST(PlacedBox, FacesInOrOut) {
  bed::BoxParameters p{.name = "b", .material = "steel", .low = {0, 0, 0}, .high = {1, 2, 3}};
  p.axis = {1, 1, 1}, p.angle = 50;
  for (const auto side : {bed::BoxSide::inside, bed::BoxSide::outside}) {
    p.side = side;
    const bed::PlacedSurfaces placed({}, {p}, steel(), Dimension::space, 1);
    EXPECT_NEAR(enclosed(placed.surfaces()[0]), side == bed::BoxSide::outside ? 6 : -6, 1e-13);
  }
  EXPECT_EQ(
      bed::PlacedSurfaces({}, {p}, steel(), Dimension::plane, 1).surfaces()[0].triangles.size(),
      8U);
}

// Core, slabs, quarter cylinders along edges, eighths of a sphere.
TEST(PlacedShape, BlockHasItsOverallLengths) {
  bed::ShapeParameters p;
  p.shape = bed::ShapeKind::block, p.sides = {0.06, 0.04, 0.02}, p.rounding = 2e-3;
  const bed::PlacedShape made = bed::placed_shape(par::Comm::self(), p, Dimension::space);
  const double x = 0.056, y = 0.036, z = 0.016, r = 2e-3;
  const double volume = x * y * z + 2 * r * (x * y + y * z + z * x) + pi * r * r * (x + y + z) +
                        4 * pi / 3 * r * r * r;
  EXPECT_NEAR(made.shape.volume, volume, 1e-12 * volume);
  Vec3 high = Vec3::Zero();
  for (const Vec3& corner : made.shape.pieces[0].core.vertices)
    high = high.cwiseMax(made.axes * corner + Vec3::Constant(r));
  EXPECT_LT((high - Vec3(0.03, 0.02, 0.01)).norm(), 1e-15);
}

TEST(PlacedShape, BlockPassesTheHoleOfTheGeneralSearch) {
  for (const std::vector<double>& sides :
       {std::vector<double>{0.06, 0.04, 0.02}, {0.05, 0.01, 0.04}}) {
    bed::ShapeParameters p;
    p.shape = bed::ShapeKind::block, p.sides = sides, p.rounding = 1e-3;
    const bed::PlacedShape made = bed::placed_shape(par::Comm::self(), p, Dimension::space);
    // The search is accurate to 1e-6 of the size.
    EXPECT_NEAR(geom::smallest_hole(made.shape.pieces), made.shape.sieve, 1e-6 * made.shape.sieve);
  }
}

// A right-angled tetrahedron is not aligned with its principal axes.
TEST(PlacedShape, AttitudeRefersToTheAxesOfTheDeck) {
  bed::ShapeParameters p;
  p.shape = bed::ShapeKind::hull, p.rounding = 1e-9;
  p.corners = {0, 0, 0, 0.03, 0, 0, 0, 0.02, 0, 0, 0, 0.01};
  const bed::PlacedShape made = bed::placed_shape(par::Comm::self(), p, Dimension::space);
  const Vec3 centre(0.0075, 0.005, 0.0025);
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 given(p.corners[3 * k], p.corners[3 * k + 1], p.corners[3 * k + 2]);
    const Vec3 found = made.axes * made.shape.pieces[0].core.vertices[k] + centre;
    EXPECT_LT((found - given).norm(), 1e-8);
  }
  EXPECT_NEAR(made.shape.volume, 1e-6, 1e-15);
}

TEST(PlacedShape, GeneratedStonesHaveTheSpecifiedSize) {
  bed::ShapeParameters p;
  p.shape = bed::ShapeKind::polyhedron, p.size = 0.03;
  const bed::PlacedShape made = bed::placed_shape(par::Comm::self(), p, Dimension::space);
  EXPECT_NEAR(made.scale * made.shape.sieve, 0.03, 1e-15);
}

}  // namespace
}  // namespace trackbed::placed_test
