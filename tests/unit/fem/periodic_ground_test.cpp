// Both ends of a periodic ground are one: results are invariant to a shift along it, and a short
// periodic ground equals a long one of many copies.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "trackbed/io/file.hpp"
#include "unit/fem/compared.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem::periodic_ground_test {
namespace {

using par::Comm;

void repeat(GroundParameters& p, int axis) {
  if (axis == 0)
    p.side_x_low = p.side_x_high = Sides::periodic;
  else
    p.side_y_low = p.side_y_high = Sides::periodic;
}

// 6 m long and 4 m wide from the origin, both periodic; two layers, springs, damping of all kinds.
GroundParameters repeated(Integrator integrator) {
  GroundParameters p = box({6, 4, 1}, {12, 6, 5}, {});
  p.layers = {{"soft", 1, {60e6, 0.35, 1700}}, {"stiff", 1.5, {200e6, 0.3, 2000}}};
  p.layers[1].solid.rayleigh_stiffness = 3e-5;
  p.rayleigh_mass = 3, p.rayleigh_stiffness = 2e-5;
  p.plane = PlaneState::strain;
  p.sides = Sides::viscous;
  repeat(p, 0), repeat(p, 1);
  p.integrator = integrator;
  p.tolerance = 1e-12;
  return p;
}

// Shifted back into one period.
double home(double at, double length) { return at - length * std::floor(at / length + 1e-9); }
Vec3 shifted(const Vec3& at, double x, double y) {
  return {home(at.x() + x, 6), home(at.y() + y, 4), at.z()};
}

// A traction without symmetry, the same at both ends, Pa.
Vec3 uneven(const Vec3& at) {
  const double x = home(at.x(), 6), y = home(at.y(), 4);
  return 1e3 * Vec3(std::sin(x + 2 * y), std::cos(1.3 * x), -30 * std::exp(-(x - 1) * (x - 1) - y));
}

class PeriodicIn : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, PeriodicIn, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Largest difference between a ground and one with a shifted load, at places with the same shift;
// and the energy dissipated by yielding.
struct Moved {
  double apart, plastic;  // -, J
};
Moved moved(const GroundParameters& p, Dimension dimension, double size) {
  const Comm comm = Comm::world();
  const bool plane = dimension == Dimension::plane;
  Ground fixed(comm, p, dimension, 1.0), far(Comm::self(), p, dimension, 1.0);
  const auto load = [&](Ground& ground, double x, double y) {
    return traction_forces(ground, [&](const Vec3& at) -> Vec3 {
      return size * uneven(plane ? Vec3(home(at.x() + x, 6), 0, 0) : shifted(at, x, y));
    });
  };
  const auto here = load(fixed, 0, 0), there = load(far, 3, 2);
  fixed.settle(load(fixed, 1, 1)), far.settle(load(far, 4, 3));
  double worst = 0;
  for (int w = 0; w < 40; ++w) {
    fixed.advance(4e-4, w < 20 ? here : none(fixed));
    far.advance(4e-4, w < 20 ? there : none(far));
    if (w % 10 == 9)
      worst = std::max(worst, apart(comm, fixed, far, [&](const Vec3& at) -> Vec3 {
                         const Vec3 partner = shifted(at, -3, -2);
                         return plane ? Vec3(partner.x(), at.y(), at.z()) : partner;
                       }));
  }
  return {worst, far.totals().plastic};
}

TEST_P(PeriodicIn, ShiftedLoadGivesTheShiftedResponse) {
  EXPECT_LT(moved(repeated(Integrator::explicit_), GetParam(), 1).apart, 1e-10);
  EXPECT_LT(moved(repeated(Integrator::newmark), GetParam(), 1).apart, 1e-7);
  EXPECT_LT(moved(repeated(Integrator::hht), GetParam(), 1).apart, 1e-7);
}

GroundParameters weak(Integrator integrator) {
  GroundParameters p = repeated(integrator);
  p.layers[0].strength = {Yield::mohr_coulomb, 4e3, 25, 5, 1e3};
  return p;
}

// Yielding at the seam is the same as elsewhere.
TEST_P(PeriodicIn, ShiftedLoadGivesTheShiftedResponseOfAYieldingGround) {
  const Moved steps = moved(weak(Integrator::explicit_), GetParam(), 1.5);
  EXPECT_LT(steps.apart, 1e-8);
  EXPECT_GT(steps.plastic, 1);
  const Moved implicit = moved(weak(Integrator::newmark), GetParam(), 1.5);
  EXPECT_LT(implicit.apart, 1e-4);  // tolerance of Newton's method
  EXPECT_GT(implicit.plastic, 1);
}

// Steps propagate by one element each: until effects of the ends arrive, the middle one of seven
// copies equals the periodic ground.
TEST_P(PeriodicIn, IsOneOfManyCopies) {
  const Comm comm = Comm::world();
  GroundParameters p = repeated(Integrator::explicit_);
  repeat(p, 0);
  p.side_y_low = p.side_y_high = Sides::as_sides;
  GroundParameters many = p;
  many.x = {-18, 24}, many.elements_x = 7 * 12;
  many.side_x_low = many.side_x_high = Sides::as_sides;
  Ground one(comm, p, GetParam(), 1.0), all(Comm::self(), many, GetParam(), 1.0);
  const double dt = one.stable_step();
  for (Ground* ground : {&one, &all}) {
    const auto load = traction_forces(*ground, [](const Vec3& at) -> Vec3 {
      return {0, 0, 1e3 * std::min(0.0, std::abs(home(at.x(), 6) - 5) - 1)};
    });
    for (int w = 0; w < 35; ++w) ground->advance(dt, load);
  }
  EXPECT_LT(apart(comm, one, all, [](const Vec3& at) { return at; }), 1e-11);
  // By then the waves of the load have travelled around the period: 35 steps of 0.6 elements.
  EXPECT_GT(35 * dt * 183, 0.5 * 6);
}

// Without lateral strain each element carries the weight above it, as between rollers.
TEST_P(PeriodicIn, WeightActsAsInAColumn) {
  for (const std::int64_t elements : {1, 3}) {
    GroundParameters p = box({2, 2, 5}, {elements, elements, 10}, {50e6, 0.3, 2000});
    p.plane = PlaneState::strain;
    p.base = Base::fixed;
    p.tolerance = 1e-12;
    repeat(p, 0), repeat(p, 1);
    Ground ground(Comm::world(), p, GetParam(), 2.0);
    ground.settle(pressure(ground, 50e3));
    const io::Grid grid = ground.fields();
    double worst = 0;
    for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
      double z = 0;
      for (std::size_t k = 0; k < 8; ++k)
        z += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])].z() / 8;
      const double exact = -50e3 + 2000 * gravity * z;
      for (const auto& [component, share] : {std::pair{0, 0.3 / 0.7}, {1, 0.3 / 0.7}, {2, 1.0}})
        worst =
            std::max(worst, std::abs(grid.cell_data[1].values[6 * c + component] - share * exact));
    }
    EXPECT_LT(Comm::world().max(worst), 1e-6 * 150e3);
    const std::int64_t nodes = GetParam() == Dimension::plane ? elements : elements * elements;
    EXPECT_EQ(ground.totals().nodes, nodes * 11);
    EXPECT_EQ(ground.totals().unknowns, nodes * 10 * (GetParam() == Dimension::plane ? 2 : 3));
  }
}

// One element across, periodic, is plane strain.
TEST(PeriodicAcross, IsPlaneStrain) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::bossak}) {
    GroundParameters p = repeated(integrator);
    p.y = {-0.5, 0.5}, p.elements_y = 1;
    p.side_x_low = p.side_x_high = Sides::as_sides;
    Ground plane(Comm::self(), p, Dimension::plane, 1.0), space(comm, p, Dimension::space, 1.0);
    for (Ground* ground : {&plane, &space}) {
      const auto load = traction_forces(
          *ground, [](const Vec3& at) -> Vec3 { return 1e3 * Vec3(at.x(), 0, -10 - at.x()); });
      for (int w = 0; w < 30; ++w) ground->advance(4e-4, load);
    }
    EXPECT_LT(apart(comm, space, plane, [](const Vec3& at) { return at; }),
              integrator == Integrator::explicit_ ? 1e-10 : 1e-7);
  }
}

// A level ground moves uniformly under a wave, for any condition of the other sides.
TEST_P(PeriodicIn, LevelGroundMovesUniformlyUnderAWave) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark})
    for (const int axes : {1, 2, 3}) {
      GroundParameters p = repeated(integrator);
      p.sides = Sides::free_field;
      if ((axes & 1) == 0) p.side_x_low = p.side_x_high = Sides::as_sides;
      if ((axes & 2) == 0) p.side_y_low = p.side_y_high = Sides::as_sides;
      p.base_motion = wave_table(comm, "periodic", {50, 0.03}, 1.0, 0.7, 5e-4);
      Ground ground(comm, p, GetParam(), 1.0);
      ground.settle(none(ground));
      const Spread found = spread_in_a_wave(comm, ground);
      EXPECT_GT(found.largest, 1e-6);
      EXPECT_LT(found.apart / found.largest, integrator == Integrator::explicit_ ? 1e-11 : 1e-8)
          << axes;
    }
}

TEST_P(PeriodicIn, IsBitwiseIdenticalOnAnyRankCount) {
  const Comm world = Comm::world();
  for (const bool yields : {false, true}) {
    GroundParameters p = yields ? weak(Integrator::explicit_) : repeated(Integrator::explicit_);
    Ground alone(Comm::self(), p, GetParam(), 1.0), spread(world, p, GetParam(), 1.0);
    for (Ground* ground : {&alone, &spread}) {
      if (yields) ground->settle(traction_forces(*ground, uneven));  // exact sums
      for (int w = 0; w < 25; ++w) ground->advance(5e-4, load_of(ground->top(), w));
    }
    EXPECT_EQ(bits(Comm::self(), alone), bits(world, spread));
    EXPECT_GT(alone.totals().kinetic, 0);
    for (const std::int32_t own : spread.own_top()) {
      const auto n = static_cast<std::size_t>(own);
      EXPECT_EQ(alone.top().position[n], spread.top().position[n]);
      EXPECT_EQ(alone.top().motion[n], spread.top().motion[n]);
    }
  }
}

// Mass damping acts on the mass of both ends; masses of the surface add up to those of the
// uppermost half row of elements.
TEST_P(PeriodicIn, MassIsShared) {
  const Comm comm = Comm::world();
  Ground ground(comm, repeated(Integrator::explicit_), GetParam(), 4.0);
  double sum = 0, most = 0, least = 1e300;
  for (const std::int32_t n : ground.own_top()) {
    const double mass = ground.top_mass(n);
    sum += mass, most = std::max(most, mass), least = std::min(least, mass);
  }
  EXPECT_NEAR(comm.sum(sum), 1700 * 6 * 4 * 0.25, 1e-8);
  // A place listed four times has a quarter, in a plane (two faces) a half of the mass of others.
  EXPECT_NEAR(comm.max(most) / -comm.max(-least), GetParam() == Dimension::plane ? 2 : 4, 1e-9);
}

TEST_P(PeriodicIn, ContinuesBitwiseIdentically) {
  const Comm world = Comm::world(), self = Comm::self();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::hht})
    for (const bool yields : {false, true}) {
      const bool one = integrator != Integrator::explicit_;  // implicit results depend on the ranks
      const Comm& comm = one ? self : world;
      const GroundParameters p = yields ? weak(integrator) : repeated(integrator);
      const std::string path =
          fmt::format("periodic_{}_{}.h5", world.size(), one ? world.rank() + 1 : 0);
      Ground straight(comm, p, GetParam(), 1.0), resumed(comm, p, GetParam(), 1.0);
      straight.settle(traction_forces(straight, uneven));
      for (int w = 0; w < 8; ++w) straight.advance(4e-4, load_of(straight.top(), w));
      {
        io::File file(comm, path, io::Mode::create);
        straight.save(file, "ground");
      }
      {
        const io::File file(comm, path, io::Mode::read);
        resumed.load(file, "ground");
      }
      for (Ground* ground : {&straight, &resumed})
        for (int w = 0; w < 8; ++w) ground->advance(4e-4, load_of(ground->top(), w));
      EXPECT_EQ(bits(comm, straight), bits(comm, resumed));
    }
}

}  // namespace
}  // namespace trackbed::fem::periodic_ground_test
