// Walls of boxes and cylinders: their positions, normals and motion.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "bed/columns.hpp"
#include "trackbed/bed/bed.hpp"

namespace trackbed::bed::container_test {
namespace {

dem::Domain domain() {
  dem::Domain d;
  d.low = {-0.1, -0.1, -0.2};
  d.high = {0.5, 0.5, 3};
  return d;
}

BedParameters parameters(ContainerKind kind) {
  BedParameters p;
  p.stone = StoneKind::disk;
  p.x = {0, 0.4};
  p.y = {0, 0.4};
  p.height = 0.3;
  p.container = kind;
  return p;
}

Vec3 node(const Surface& s, std::int32_t n) { return s.position[static_cast<std::size_t>(n)]; }

// Normal and middle of each vertical triangle.
template <class F>
void visit_vertical(const Surface& wall, F&& visit) {
  for (const auto& t : wall.triangles) {
    const Vec3 a = node(wall, t[0]), b = node(wall, t[1]), c = node(wall, t[2]);
    const Vec3 normal = (b - a).cross(c - a).normalized();
    if (std::abs(normal.z()) < 0.5) visit(normal, (a + b + c) / 3);
  }
}

TEST(ACylinder, HasTheAreaOfItsPolygonAndFacesItsAxis) {
  const Container c = parameters(ContainerKind::cylinder).container_in(domain());
  const auto all = walls(c, 0.5, 2, true);
  ASSERT_EQ(all.size(), 2u);
  const Surface& wall = all[1];
  EXPECT_EQ(wall.name, "wall.cylinder");
  // The shoelace formula over the nodes at one height, each of which occurs once.
  std::map<double, Vec3> around;
  for (const Vec3& x : wall.position)
    if (x.z() == 0.5) around[std::atan2(x.y() - 0.2, x.x() - 0.2)] = x;
  ASSERT_EQ(around.size(), static_cast<std::size_t>(facets));
  double area = 0;
  Vec3 last = around.rbegin()->second;
  for (const auto& [turn, x] : around) {
    area += (last.x() * x.y() - last.y() * x.x()) / 2;
    last = x;
  }
  constexpr double rounding = 1e-12;
  EXPECT_NEAR(c.area(), area, rounding);
  // The stated fraction by which the circle is larger.
  const double circle = std::numbers::pi * 0.2 * 0.2;
  EXPECT_NEAR(1 - c.area() / circle, 0.0016, 0.0001);
  visit_vertical(wall, [&](const Vec3& normal, const Vec3& middle) {
    const Vec3 inwards = Vec3(0.2 - middle.x(), 0.2 - middle.y(), 0);
    EXPECT_GT(normal.dot(inwards.normalized()), 0.99);
    EXPECT_NEAR(normal.dot(inwards), c.clear_radius(), 1e-9);
  });
}

TEST(ACylinder, GetsStonesInProportionToItsArea) {
  const BedParameters round = parameters(ContainerKind::cylinder);
  const BedParameters square = parameters(ContainerKind::box);
  const Mix mix(round, Dimension::space);
  const Columns in_round(round, domain(), mix), in_square(square, domain(), mix);
  const double fraction = round.container_in(domain()).area() / (0.4 * 0.4);
  EXPECT_NEAR(static_cast<double>(in_round.stones()),
              fraction * static_cast<double>(in_square.stones()), 1);
  std::vector<dem::NewParticle> stones;
  for (std::int64_t c = 0; c < in_round.count(); ++c) in_round.build(c, stones);
  ASSERT_EQ(static_cast<std::int64_t>(stones.size()), in_round.stones());
  const double clear = round.container_in(domain()).clear_radius();
  double furthest = 0;
  for (const dem::NewParticle& stone : stones) {
    const double r = mix.bound({stone.shape, stone.scale});
    const Vec3 from(stone.position.x() - 0.2, stone.position.y() - 0.2, 0);
    furthest = std::max(furthest, from.norm() + r);
  }
  EXPECT_LT(furthest, clear);
  EXPECT_GT(furthest, 0.9 * clear);  // up to the wall
}

TEST(ThePlaten, HasThePressureOnTheAreaOfTheCylinder) {
  const Container c = parameters(ContainerKind::cylinder).container_in(domain());
  Platen platen({}, c, 0);
  platen.place(0.3);
  for (int k = 0; k < 2000; ++k) platen.advance(1e-4, 1000);
  EXPECT_NEAR(platen.pressure(), 1000 / c.area(), 1e-3 * 1000 / c.area());
}

TEST(DividedWalls, MoveTheirLowerHalfWithTheFloor) {
  BedParameters p = parameters(ContainerKind::box);
  p.split = 0.1, p.beside = 0.05;
  Walls moved(p.container_in(domain()), 1, 2);
  EXPECT_EQ(moved.height(), 0);
  moved.build(0.6);
  ASSERT_EQ(moved.surfaces().size(), 9u);
  ASSERT_EQ(moved.names().size(), 9u);
  EXPECT_EQ(moved.surfaces()[0].material, 2);
  EXPECT_EQ(moved.surfaces()[1].material, 1);
  const auto initial = moved.surfaces();
  moved.move(0.01, 0);
  moved.move(0.02, 0);
  for (std::size_t k = 0; k < initial.size(); ++k) {
    const Surface& wall = moved.surfaces()[k];
    EXPECT_EQ(wall.name, moved.names()[k]);
    const bool lower = wall.name == "floor" || wall.name.ends_with(".lower");
    EXPECT_EQ(moved.displacement(wall.name), Vec3(lower ? 0.03 : 0, 0, 0)) << wall.name;
    for (std::size_t n = 0; n < wall.nodes(); ++n) {
      EXPECT_EQ(wall.position[n], initial[k].position[n] + Vec3(lower ? 0.01 : 0, 0, 0));
      EXPECT_EQ(wall.motion[n], Vec3(lower ? 0.02 : 0, 0, 0));
      EXPECT_TRUE(!wall.name.ends_with(".lower") || wall.position[n].z() <= 0.1);
      EXPECT_TRUE(!wall.name.ends_with(".upper") || wall.position[n].z() >= 0.1);
    }
  }
}

// Rims cover the gap that opens beside the halves at the largest displacement of the lower one.
TEST(DividedWalls, HaveRimsAsWideAsTheFloorAround) {
  BedParameters p = parameters(ContainerKind::box);
  p.split = 0.1, p.beside = 0.05;
  for (const Surface& wall : walls(p.container_in(domain()), 0.6, 1, true)) {
    if (wall.name == "floor") continue;
    const bool lower = wall.name.ends_with(".lower");
    bool rim = false;
    for (const auto& t : wall.triangles) {
      const Vec3 a = node(wall, t[0]), b = node(wall, t[1]), c = node(wall, t[2]);
      const Vec3 normal = (b - a).cross(c - a).normalized();
      if (std::abs(normal.z()) < 0.5) continue;
      rim = true;
      EXPECT_NEAR(normal.z(), lower ? 1 : -1, 1e-12) << wall.name;
      EXPECT_EQ(a.z(), 0.1);
    }
    EXPECT_TRUE(rim) << wall.name;
    const bool along_x = wall.name.starts_with("wall.left") || wall.name.starts_with("wall.right");
    double out = 0;
    for (const Vec3& x : wall.position) {
      const double at = along_x ? x.x() : x.y();
      out = std::max(out, std::max(-at, at - 0.4));
    }
    EXPECT_GT(out, 2 * p.beside) << wall.name;
  }
}

TEST(LiftedWalls, LeaveTheFloorBehind) {
  BedParameters p = parameters(ContainerKind::cylinder);
  p.beside = 0.3;
  Walls lifted(p.container_in(domain()), 1, 2);
  EXPECT_EQ(lifted.names()[0], "floor");
  lifted.build(0.6);
  ASSERT_EQ(lifted.surfaces().size(), 2u);
  // A board is touched on both sides: as many faces away from the axis as towards it.
  int inwards = 0, outwards = 0;
  visit_vertical(lifted.surfaces()[1], [&](const Vec3& normal, const Vec3& middle) {
    ++(normal.dot(Vec3(0.2 - middle.x(), 0.2 - middle.y(), 0)) > 0 ? inwards : outwards);
  });
  EXPECT_EQ(inwards, 2 * facets);
  EXPECT_EQ(outwards, 2 * facets);
  const double floor = lifted.surfaces()[0].position[0].z();
  lifted.move(0, 0.1);
  lifted.move(0, 0);
  EXPECT_EQ(lifted.surfaces()[0].position[0].z(), floor);
  EXPECT_EQ(lifted.displacement("wall.cylinder"), Vec3(0, 0, 0.1));
  lifted.remove();
  ASSERT_EQ(lifted.surfaces().size(), 1u);
  EXPECT_EQ(lifted.surfaces()[0].name, "floor");
  EXPECT_EQ(lifted.names().size(), 2u);  // columns of the histories remain
}

}  // namespace
}  // namespace trackbed::bed::container_test
