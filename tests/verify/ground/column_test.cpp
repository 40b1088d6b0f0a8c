// Waves in a column (reference case "Column"): 1 kPa step on top of 10 m, plane strain and space.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "verify/ground/half_space.hpp"

namespace trackbed::fem::column_test {
namespace {

using par::Comm;

constexpr double wave_speed = 183.4498;            // m/s
constexpr double particle_velocity = 2.725541e-3;  // m/s
constexpr double step_pressure = 1e3;              // Pa

// Oscillations behind a front have a third of its velocity and a period of 1 ms; windows in which
// the velocity is averaged are 30 ms long.
const verified::Tolerance one_front{3e-3, "oscillations behind the front: 0.3 * 1 ms / (pi 30 ms)"};
const verified::Tolerance fronts{0.01, "oscillations behind three fronts: 3e-3 each"};

// Downward velocity at height z from the output fields, on every rank.
double downward_velocity(const Comm& comm, const Ground& ground, double z) {
  const io::Grid grid = ground.fields();
  double found = -1e300;
  for (std::size_t n = 0; n < grid.points.size(); ++n)
    if (std::abs(grid.points[n].z() - z) < 1e-6)
      found = std::max(found, -grid.point_data[1].values[3 * n + 2]);
  return comm.max(found);
}

double top_displacement(const Comm& comm, const Ground& ground) {
  double found = -1e300;
  for (const auto n : ground.own_top())
    found = std::max(found, -ground.top_state(n).displacement.z());
  return comm.max(found);
}

class Column : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Column, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

TEST_P(Column, FrontArrivesInTimeWithTheRightVelocity) {
  const Comm comm = Comm::world();
  GroundParameters p = column(200);
  Ground ground(comm, p, GetParam(), 1.0);
  const auto load = pressure(ground, step_pressure);
  const double dt = ground.stable_step();
  const std::array<double, 3> depth = {2.5, 5.0, 7.5};
  const std::array<double, 3> exact = {13.6277e-3, 27.2554e-3, 40.8831e-3};
  std::array<double, 3> arrival{}, before{};
  double sum = 0;
  int samples = 0;
  for (double t = dt; t < 52e-3; t += dt) {
    ground.advance(dt, load);
    for (std::size_t i = 0; i < 3; ++i) {
      const double v = downward_velocity(comm, ground, -depth[i]), half = 0.5 * particle_velocity;
      if (arrival[i] == 0 && v > half) arrival[i] = t - dt * (v - half) / (v - before[i]);
      before[i] = v;
    }
    if (t > 20e-3) sum += before[0], ++samples;
  }
  const verified::Tolerance front{0.1 / wave_speed,
                                  "the front is smeared over two of 200 elements: 0.1 m / c_p"};
  for (std::size_t i = 0; i < 3; ++i)
    verified::near(fmt::format("arrival at {:g} m", depth[i]), "s", arrival[i], exact[i], front);
  verified::near("particle velocity", "m/s", sum / samples, particle_velocity,
                 one_front.of(particle_velocity));
}

// No reflection at the viscous base: the whole column keeps the particle velocity.
TEST_P(Column, ViscousBaseAbsorbs) {
  const Comm comm = Comm::world();
  GroundParameters p = column(100);
  p.base = Base::viscous;
  p.base_stiffness = 0;
  Ground ground(comm, p, GetParam(), 1.0);
  const auto load = pressure(ground, step_pressure);
  const double travel = 10 / wave_speed;
  while (ground.top().position[0].z() == 0 && ground.totals().steps == 0)
    ground.advance(4 * travel, load);
  double sum = 0;
  constexpr int samples = 40;
  for (int s = 0; s < samples; ++s) {
    ground.advance(travel / samples, load);
    sum += downward_velocity(comm, ground, -5.0);
  }
  const verified::Tolerance after{2e-3, "oscillations behind the front, after four travel times"};
  verified::near("particle velocity", "m/s", sum / samples, particle_velocity,
                 after.of(particle_velocity));
}

// An interface reflects (1 - a)/(1 + a) of the velocity, a = impedance below over above; the free
// top doubles it. a = 2 through density and stiffness: c_p is the same in both.
TEST_P(Column, ImpedanceJumpReflectsItsFraction) {
  const Comm comm = Comm::world();
  GroundParameters p = column(200);
  p.layers = {{"soft", 5, {50e6, 0.3, 2000}}, {"stiff", 5, {100e6, 0.3, 4000}}};
  p.base = Base::viscous;
  p.base_stiffness = 0;
  Ground ground(comm, p, GetParam(), 1.0);
  const auto load = pressure(ground, step_pressure);
  const double travel = 5 / wave_speed;
  ground.advance(2.4 * travel, load);
  double sum = 0;
  constexpr int samples = 40;
  for (int s = 0; s < samples; ++s) {
    ground.advance(1.2 * travel / samples, load);
    sum += downward_velocity(comm, ground, 0);
  }
  const double a = 2, expected = 1 + 2 * (1 - a) / (1 + a);
  verified::near("velocity of the top over the first one", "-", sum / samples / particle_velocity,
                 expected, fronts);
}

// A dashpot a rho c reflects (1 - a)/(1 + a): dashpots of a base whose lowest elements, a hundredth
// of the column, have a times the impedance of the others. The transmitted front has 2/(1 + a).
TEST_P(Column, DashpotReflectsItsFraction) {
  const Comm comm = Comm::world();
  for (const double a : {0.5, 3.0}) {
    GroundParameters p = column(200);
    p.layers = {{"column", 9.9, {50e6, 0.3, 2000}}, {"base", 0.1, {50e6 * a, 0.3, 2000 * a}}};
    p.base = Base::viscous;
    p.base_stiffness = 0;
    Ground ground(comm, p, GetParam(), 1.0);
    const auto load = pressure(ground, step_pressure);
    const double travel = 10 / wave_speed;  // the front is back at mid-height after 1.5 of them
    ground.advance(1.7 * travel, load);
    double sum = 0;
    constexpr int samples = 40;
    for (int s = 0; s < samples; ++s) {
      ground.advance(0.6 * travel / samples, load);
      sum += downward_velocity(comm, ground, -5.0);
    }
    verified::near(fmt::format("reflected fraction of the velocity, a = {:g}", a), "-",
                   sum / samples / particle_velocity - 1, (1 - a) / (1 + a), fronts);
  }
}

TEST_P(Column, SettlesByItsStaticDisplacement) {
  const Comm comm = Comm::world();
  Ground ground(comm, half_space(column(20)), GetParam(), 1.0);
  load_statically(ground, pressure(ground, step_pressure));
  // Linear displacement: exact on any mesh.
  verified::near("displacement of the top", "m", top_displacement(comm, ground), 0.148571e-3,
                 {5e-10, "six digits of the reference"});
}

TEST_P(Column, FixedBaseReachesTwiceTheStaticDisplacement) {
  const Comm comm = Comm::world();
  Ground ground(comm, column(100), GetParam(), 1.0);
  const auto load = pressure(ground, step_pressure);
  const double dt = 0.2e-3, period = 218.043e-3;
  double largest = 0, when = 0, before = 0, back = 0;
  for (int w = 1; w * dt < 1.3 * period; ++w) {
    ground.advance(dt, load);
    const double u = top_displacement(comm, ground);
    if (u > largest) largest = u, when = w * dt;
    if (back == 0 && w * dt > 0.75 * period && u > before) back = w * dt;  // reversal of the motion
    before = u;
  }
  const verified::Tolerance corner{
      0.01, "the corner of the motion is smeared over two of 100 elements: 1/100 of 2 H"};
  verified::near("largest displacement", "m", largest, 0.297143e-3, corner.of(0.297143e-3));
  verified::near("time of the largest", "s", when, 0.5 * period, corner.of(period));
  verified::near("period", "s", back, period, corner.of(period));
}

}  // namespace
}  // namespace trackbed::fem::column_test
