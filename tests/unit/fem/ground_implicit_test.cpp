// Implicit steps and static solves on several ranks: agreement to the solver's tolerance, agreement
// with the explicit scheme, static equilibrium, failure of a solve.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <array>
#include <cmath>

#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::ground_implicit_test {
namespace {

using par::Comm;

GroundParameters scene(Integrator integrator) {
  GroundParameters p = box({3, 1, 2}, {12, 4, 8}, {80e6, 0.35, 1900});
  p.layers = {{"a", 0.7, {80e6, 0.35, 1900}}, {"b", 1.3, {200e6, 0.3, 2000}}};
  p.sides = Sides::viscous;
  p.base_stiffness = 1e8;
  p.rayleigh_mass = 2, p.rayleigh_stiffness = 2e-5;
  p.integrator = integrator;
  p.tolerance = 1e-11;
  return p;
}

// A load that rises and falls smoothly over 20 ms, so that both schemes resolve it.
double pulse(double time) { return 1 - std::cos(2 * M_PI * std::min(time, 0.02) / 0.02); }

// Vertical displacement of every top node on every rank at time `end`.
std::vector<double> run(const Comm& comm, Ground& ground, double dt, double end = 0.025) {
  const auto windows = static_cast<int>(std::lround(end / dt));
  const auto unit = pressure(ground, 1e3);  // of the flat top, before it moves
  auto load = unit;
  for (int w = 1; w <= windows; ++w) {
    for (std::size_t n = 0; n < load.size(); ++n) load[n] = pulse(w * dt) * unit[n];
    ground.advance(dt, load);
  }
  std::vector<double> u(ground.top().nodes(), 0.0);
  for (const auto n : ground.own_top())
    u[static_cast<std::size_t>(n)] = ground.top_state(n).displacement.z();
  comm.sum(std::span<double>(u));
  return u;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, size = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    difference = std::max(difference, std::abs(a[n] - b[n]));
    size = std::max(size, std::abs(a[n]));
  }
  return difference / size;
}

// Most negative vertical displacement of the top, m.
double lowest(const Ground& ground) {
  double most = 0;
  for (const auto n : ground.own_top())
    most = std::max(most, -ground.top_state(n).displacement.z());
  return -Comm::world().max(most);
}

class Implicit : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Implicit, ::testing::Values(Dimension::plane, Dimension::space));

TEST_P(Implicit, RanksAgreeToTheTolerance) {
  const auto p = scene(Integrator::newmark);
  Ground alone(Comm::self(), p, GetParam(), 1.0), spread(Comm::world(), p, GetParam(), 1.0);
  // At the peak of the load, so that the difference is relative to the full displacement. The
  // condition number of the operator is about 1 + beta (dt w_max)^2, here a few hundred.
  const double end = 0.012, bound = 1e3 * p.tolerance;
  const auto a = run(Comm::self(), alone, 1e-3, end), b = run(Comm::world(), spread, 1e-3, end);
  EXPECT_LT(largest_difference(a, b), bound);
  EXPECT_EQ(spread.totals().steps, 12);
  EXPECT_GT(spread.totals().iterations_mean, 0.5);
  EXPECT_TRUE(std::isinf(spread.stable_step()));
}

// Both are second order: their difference decreases fourfold when Newmark's step is halved. Both
// loads are taken at the ends of windows; the explicit scheme keeps it constant, so its windows are
// short.
TEST_P(Implicit, ConvergesToTheExplicitSolution) {
  Ground reference(Comm::world(), scene(Integrator::explicit_), GetParam(), 1.0);
  const auto exact = run(Comm::world(), reference, 5e-6);
  Ground coarse(Comm::world(), scene(Integrator::newmark), GetParam(), 1.0);
  Ground fine(Comm::world(), scene(Integrator::newmark), GetParam(), 1.0);
  const double with_1ms = largest_difference(exact, run(Comm::world(), coarse, 1e-3));
  const double with_half = largest_difference(exact, run(Comm::world(), fine, 0.5e-3));
  EXPECT_LT(with_half, 0.02);
  EXPECT_NEAR(std::log2(with_1ms / with_half), 2, 0.35) << with_1ms << ' ' << with_half;
}

// Under a smooth load the last acceleration as initial guess needs 5.0 iterations in a plane and in
// space, the parabola through the last three 3.9 and 4.1.
TEST_P(Implicit, GuessFollowsTheMotion) {
  GroundParameters p = scene(Integrator::newmark);
  p.tolerance = 1e-8;
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  run(Comm::world(), ground, 0.25e-3, 0.02);
  EXPECT_LT(ground.totals().iterations_mean, 4.5);
}

constexpr std::array integrators = {Integrator::newmark, Integrator::hht, Integrator::bossak,
                                    Integrator::generalized_alpha};

// All integrators, with springs, dashpots and damping of both kinds.
TEST_P(Implicit, EveryIntegratorConvergesToTheSameMotion) {
  const auto error = [&](Integrator integrator, double dt, const std::vector<double>& exact) {
    Ground ground(Comm::world(), scene(integrator), GetParam(), 1.0);
    return largest_difference(exact, run(Comm::world(), ground, dt, 0.015));
  };
  Ground reference(Comm::world(), scene(Integrator::newmark), GetParam(), 1.0);
  const auto exact = run(Comm::world(), reference, 0.05e-3, 0.015);
  for (const Integrator integrator : integrators) {
    const double whole = error(integrator, 0.5e-3, exact), half = error(integrator, 0.25e-3, exact);
    EXPECT_LT(half, 0.01) << static_cast<int>(integrator);
    EXPECT_NEAR(std::log2(whole / half), 2, 0.35) << whole << ' ' << half;
  }
}

TEST_P(Implicit, SettledGroundStaysAtRest) {
  for (const Integrator integrator : integrators) {
    Ground ground(Comm::world(), scene(integrator), GetParam(), 1.0);
    const auto load = pressure(ground, 2e4);
    ground.settle(load);
    for (int w = 0; w < 20; ++w) ground.advance(1e-3, load);
    for (const auto n : ground.own_top()) EXPECT_EQ(ground.top_state(n).displacement.norm(), 0);
  }
}

// In long damped steps under a constant or nearly vanishing load the residual soon vanishes, and
// the last acceleration is a much worse initial guess than zero: the solver must neither take that
// for divergence nor continue once the residual is rounding.
TEST_P(Implicit, VanishingResidualTakesFewIterations) {
  for (const Integrator integrator : {Integrator::generalized_alpha, Integrator::bossak})
    for (const double rest : {1.0, 1e-12}) {
      GroundParameters p = scene(integrator);
      p.tolerance = 1e-8, p.alpha = -1, p.rho_inf = 0;
      Ground ground(Comm::world(), p, GetParam(), 1.0);
      std::vector<Vec3> load = pressure(ground, 2e4);
      const auto advance = [&](int windows) {
        for (int w = 0; w < windows; ++w) ground.advance(1e3, load);
        return lowest(ground);
      };
      const auto spent = [&] { return ground.totals().iterations_mean * ground.totals().steps; };
      const double loaded = advance(12);
      for (Vec3& force : load) force *= rest;
      const double left = advance(30), before = spent();
      EXPECT_NEAR(left / loaded, rest, 1e-8);
      // Ten more windows would need some eighty. Not zero: remaining velocities displace the ground
      // by rounding errors, which a solve corrects once they accumulate.
      advance(10);
      EXPECT_LT(spent() - before, 20) << rest;
      EXPECT_GT(before, 20);
    }
}

// sigma_z at the top is the pressure once the response is static.
TEST_P(Implicit, SurfaceStressIsThePressure) {
  GroundParameters p = scene(Integrator::newmark);
  p.sides = Sides::roller;
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  const auto load = pressure(ground, 2e3);
  for (int w = 0; w < 60; ++w) ground.advance(0.05, load);
  for (const auto n : ground.own_top())
    EXPECT_NEAR(ground.top_state(n).sigma_z, -2e3, 20) << n;  // 1 %: remaining vibration
}

// Options are passed to the solver, and its failure is an error of the run.
TEST(Petsc, SolverThatStopsShortIsARunError) {
  Petsc::ensure();
  PetscOptionsSetValue(nullptr, "-ground_ksp_max_it", "1");
  Ground ground(Comm::world(), scene(Integrator::newmark), Dimension::plane, 1.0);
  const auto load = pressure(ground, 2e3);
  try {
    ground.advance(1e-3, load);
    ADD_FAILURE() << "no error";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("linear solver of the ground"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("solver_type mumps)"), std::string::npos);
  }
  PetscOptionsClearValue(nullptr, "-ground_ksp_max_it");
}

TEST(Petsc, DirectSolverByOption) {
  const auto p = scene(Integrator::newmark);
  Ground iterative(Comm::self(), p, Dimension::plane, 1.0);
  const auto expected = run(Comm::self(), iterative, 1e-3, 0.012);
  PetscOptionsSetValue(nullptr, "-ground_ksp_type", "preonly");
  PetscOptionsSetValue(nullptr, "-ground_pc_type", "cholesky");
  Ground direct(Comm::self(), p, Dimension::plane, 1.0);
  EXPECT_LT(largest_difference(expected, run(Comm::self(), direct, 1e-3, 0.012)), 1e-8);
  EXPECT_EQ(direct.totals().iterations_mean, 1);
  PetscOptionsClearValue(nullptr, "-ground_ksp_type");
  PetscOptionsClearValue(nullptr, "-ground_pc_type");
}

TEST(Ground, NotANumberIsReported) {
  Ground ground(Comm::self(), scene(Integrator::explicit_), Dimension::plane, 1.0);
  auto load = pressure(ground, 2e3);
  load[3].z() = std::nan("");
  ground.advance(1e-4, load);
  EXPECT_NE(ground.trouble().find("no finite displacement"), std::string::npos);
}

}  // namespace
}  // namespace trackbed::fem::ground_implicit_test
