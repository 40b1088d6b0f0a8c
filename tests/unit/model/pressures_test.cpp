// Pressures on the top of a ground: resultant and its position, each course over time, moving
// rectangles that leave the top.
#include "trackbed/model/pressures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "trackbed/core/error.hpp"

namespace trackbed::model::pressures_test {
namespace {

constexpr double rounding = 1e-12;  // relative

// 6 m x 2 m of elements, symmetric about y = 0.
Surface plate() {
  Surface surface;
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 10; ++i) surface.position.emplace_back(0.6 * i, 0.5 * j - 1, 0.0);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 10; ++i) {
      const int a = i + 11 * j, d = a + 11;
      surface.triangles.push_back({a, a + 1, d + 1});
      surface.triangles.push_back({a, d + 1, d});
    }
  return surface;
}

struct Load {
  Vec3 force = Vec3::Zero();  // N
  double middle = 0;          // m, mean of x weighted with the magnitude of the node forces
};

Load load_at(const PressureParameters& p, double time, bool around = false) {
  const Surface top = plate();
  const Pressures pressures(par::Comm::world(), top, around, {p});
  std::vector<Vec3> nodes(top.nodes(), Vec3::Zero());
  pressures.add(time, nodes);
  Load load;
  double size = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    load.force += nodes[n];
    size += nodes[n].norm();
    load.middle += nodes[n].norm() * top.position[n].x();
  }
  if (size > 0) load.middle /= size;
  return load;
}

PressureParameters plain(PressureCourse course) {
  PressureParameters p;
  p.name = "plain", p.x = {1.1, 2.3}, p.y = {-0.4, 0.7};
  p.pressure = 5e3, p.along = 2e3, p.across = -1e3;
  p.course = course;
  return p;
}

TEST(Pressures, ForceIsPressureTimesAreaAndItsMiddleThatOfTheRectangle) {
  const double area = 1.2 * 1.1;
  const Load load = load_at(plain(PressureCourse::dead), 0);
  EXPECT_NEAR(load.force.x(), 2e3 * area, rounding * 2e3);
  EXPECT_NEAR(load.force.y(), -1e3 * area, rounding * 1e3);
  EXPECT_NEAR(load.force.z(), -5e3 * area, rounding * 5e3);
  EXPECT_NEAR(load.middle, 1.7, rounding);
}

TEST(Pressures, WithoutYTheyActOnTheWholeWidth) {
  PressureParameters p = plain(PressureCourse::dead);
  p.y = {};
  EXPECT_NEAR(load_at(p, 0).force.z(), -5e3 * 1.2 * 2, rounding * 5e3);
}

double fraction(const PressureParameters& p, double time) {
  return load_at(p, time).force.z() / load_at(plain(PressureCourse::dead), 0).force.z();
}

TEST(Pressures, Courses) {
  PressureParameters rise = plain(PressureCourse::rise);
  rise.begin = 0.1, rise.duration = 0.4;
  EXPECT_EQ(fraction(rise, 0.1), 0);
  EXPECT_NEAR(fraction(rise, 0.2), (1 - std::cos(std::numbers::pi / 4)) / 2, rounding);
  EXPECT_NEAR(fraction(rise, 0.3), 0.5, rounding);
  EXPECT_NEAR(fraction(rise, 0.5), 1, rounding);
  EXPECT_NEAR(fraction(rise, 7), 1, rounding);
  rise.duration = 0;
  EXPECT_EQ(fraction(rise, 0.09), 0);
  EXPECT_NEAR(fraction(rise, 0.11), 1, rounding);

  PressureParameters pulse = plain(PressureCourse::pulse);
  pulse.begin = 0.1, pulse.duration = 0.4;
  EXPECT_EQ(fraction(pulse, 0.05), 0);
  EXPECT_NEAR(fraction(pulse, 0.2), 0.5, rounding);
  EXPECT_NEAR(fraction(pulse, 0.3), 1, rounding);
  EXPECT_EQ(fraction(pulse, 0.6), 0);

  PressureParameters sine = plain(PressureCourse::harmonic);
  sine.begin = 0.1, sine.frequency = 2;
  EXPECT_EQ(fraction(sine, 0.05), 0);
  EXPECT_NEAR(fraction(sine, 0.1 + 1.0 / 24), 0.5, rounding);
  EXPECT_NEAR(fraction(sine, 0.1 + 3.0 / 8), -1, rounding);
}

TEST(Pressures, TablesAreLinearAndConstantBeyondTheirEnds) {
  const std::string path = testing::TempDir() + "pressures_test.csv";
  PressureParameters p = plain(PressureCourse::table);
  p.file = path;
  std::ofstream(path) << "time_s,factor\n0.1,0.5\n0.3,-1\n0.4,2\n";
  EXPECT_NEAR(fraction(p, 0), 0.5, rounding);
  EXPECT_NEAR(fraction(p, 0.2), -0.25, rounding);
  EXPECT_NEAR(fraction(p, 0.35), 0.5, rounding);
  EXPECT_NEAR(fraction(p, 1), 2, rounding);
  std::ofstream(path) << "time_s,factor\n";
  EXPECT_THROW(p.table(), InputError);
  std::remove(path.c_str());
}

TEST(Pressures, MovingOnesActOnlyWithinTheTop) {
  PressureParameters p = plain(PressureCourse::table);
  p.course = PressureCourse::harmonic, p.frequency = 0.25, p.speed = 2;  // 1 at 1 s
  const Load inside = load_at(p, 1);
  EXPECT_NEAR(inside.middle, 3.7, rounding);
  EXPECT_NEAR(inside.force.z(), -5e3 * 1.32, rounding * 5e3);
  p.frequency = 1.0 / (4 * 2.15);  // 1 at 2.15 s: half of it is beyond 6 m
  EXPECT_NEAR(load_at(p, 2.15).force.z(), -5e3 * 0.66, 1e-9);
  p.frequency = 1.0 / 12;  // 1 at 3 s
  EXPECT_EQ(load_at(p, 3).force.norm(), 0);
}

TEST(Pressures, OnAPeriodicTopTheyEnterAgain) {
  PressureParameters p = plain(PressureCourse::table);
  p.course = PressureCourse::harmonic, p.speed = 2;
  for (const double time : {2.15, 3.0, 5.0, 40.0}) {
    p.frequency = 1 / (4 * time);  // 1 now
    EXPECT_NEAR(load_at(p, time, true).force.z(), -5e3 * 1.32, 1e-8) << time;
  }
  p.frequency = 1.0 / 12;  // after 6 m: at its start
  EXPECT_NEAR(load_at(p, 3, true).middle, 1.7, 1e-9);
  p.x = {-8, 5}, p.frequency = 1.0 / 4;  // longer than the top, two images on most of it
  EXPECT_NEAR(load_at(p, 1, true).force.z(), -5e3 * 13 * 1.1, 1e-8);
}

TEST(Pressures, AFixedOneOutsideOfTheTopIsRefused) {
  PressureParameters p = plain(PressureCourse::dead);
  p.x = {7, 8};
  EXPECT_THROW(Pressures(par::Comm::world(), plate(), false, {p}), InputError);
}

}  // namespace
}  // namespace trackbed::model::pressures_test
