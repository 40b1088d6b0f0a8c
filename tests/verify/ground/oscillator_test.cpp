// One element between rollers on a fixed base is an oscillator with one degree of freedom, whose
// discrete frequency and decay are known in closed form: periods of Newmark's and the explicit
// scheme (reference "Integrators"), energy, Rayleigh damping, springs below the base.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::oscillator_test {
namespace {

using par::Comm;

constexpr Elastic solid{50e6, 0.3, 2000};

double modulus() {
  const double nu = solid.poisson;
  return solid.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
}
// k = M A / H on half the mass.
double angular_frequency() { return std::sqrt(2 * modulus() / solid.density); }

GroundParameters oscillator(Integrator integrator) {
  GroundParameters p = box({1, 1, 1}, {1, 1, 1}, solid);
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.integrator = integrator;
  p.tolerance = 1e-13;
  p.safety = 1;
  return p;
}

// Displacement of the top about its static value under a step of 1 kPa, window after window.
std::vector<double> swing(const GroundParameters& p, Dimension dimension, double dt, int windows) {
  Ground ground(Comm::world(), p, dimension, 1.0);
  const auto load = pressure(ground, 1e3);
  const double rest = -1e3 / modulus();
  std::vector<double> u;
  for (int w = 0; w < windows; ++w) {
    ground.advance(dt, load);
    double mine = -1e300;
    for (const auto n : ground.own_top())
      mine = std::max(mine, ground.top_state(n).displacement.z() - rest);
    u.push_back(Comm::world().max(mine));
  }
  return u;
}

// Any undamped one-step scheme satisfies u_(n+1) + u_(n-1) = 2 cos(W) u_n.
double phase_per_step(const std::vector<double>& u) {
  double product = 0, square = 0;
  for (std::size_t n = 2; n + 1 < u.size(); ++n) {
    product += 0.5 * (u[n + 1] + u[n - 1]) * u[n];
    square += u[n] * u[n];
  }
  return std::acos(product / square);
}

class Oscillator : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Oscillator, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

TEST_P(Oscillator, NewmarkHasItsPeriodErrorAndConservesEnergy) {
  const double period = 2 * std::numbers::pi / angular_frequency();
  const auto u = swing(oscillator(Integrator::newmark), GetParam(), 0.1 * period, 400);
  const double error = 0.2 * std::numbers::pi / phase_per_step(u) - 1;
  verified::near("period error at dt/T = 0.1", "-", error, 0.03207,
                 {5e-6, "five decimals of the reference"});
  double early = 0, late = 0;
  for (std::size_t n = 0; n < 100; ++n) {
    early = std::max(early, std::abs(u[n + 1]));
    late = std::max(late, std::abs(u[n + 300]));
  }
  // Spectral radius 1.
  verified::near("amplitude ratio over 30 periods", "-", late / early, 1,
                 {1e-3, "peaks: 100 samples miss them by up to 0.03 rad, 5e-4, twice"});
}

TEST_P(Oscillator, ExplicitSchemeHasItsPeriodError) {
  const double period = 2 * std::numbers::pi / angular_frequency();
  const auto u = swing(oscillator(Integrator::explicit_), GetParam(), 0.1 * period, 400);
  // sin(W/2) = w h / 2.
  verified::near("phase per step at dt/T = 0.1", "rad", phase_per_step(u),
                 2 * std::asin(0.1 * std::numbers::pi),
                 {1e-12, "exact: rounding of 400 steps, 1e-16 each, over sin W"});
}

TEST_P(Oscillator, RayleighDampingHasItsDecay) {
  const double omega = angular_frequency(), ratio = 0.05;
  const double dt = 0.02 * 2 * std::numbers::pi / omega;
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark})
    for (const bool by_mass : {true, false}) {
      GroundParameters p = oscillator(integrator);
      (by_mass ? p.rayleigh_mass : p.rayleigh_stiffness) =
          by_mass ? 2 * ratio * omega : 2 * ratio / omega;
      const auto u = swing(p, GetParam(), dt, 600);
      // Amplitude from three consecutive displacements, ten periods apart.
      const double damped = omega * std::sqrt(1 - ratio * ratio);
      const auto amplitude = [&](std::size_t n) {
        const double v = (u[n + 1] - u[n - 1]) / (2 * dt);
        return std::hypot(u[n], (v + ratio * omega * u[n]) / damped);
      };
      const double decay = std::log(amplitude(50) / amplitude(550));
      // omega dt = 0.126.
      const verified::Tolerance leapfrog{4e-5, "(2 zeta omega dt)^2 / 12 = 1.3e-5, three times"};
      const verified::Tolerance lagged{0.0126, "damping forces a step late: zeta omega dt, twice"};
      const verified::Tolerance trapezoidal{8e-3, "(omega dt)^2 / 4 = 3.9e-3, twice"};
      verified::near(
          fmt::format("decay over the exact one, by {}, {}", by_mass ? "mass" : "stiffness",
                      integrator == Integrator::newmark ? "Newmark" : "explicit"),
          "-", decay / (ratio * omega * 500 * dt), 1,
          integrator == Integrator::newmark ? trapezoidal
          : by_mass                         ? leapfrog
                                            : lagged);
    }
}

// Springs parallel to dashpots: a stiff block settles by p / k_s with time constant rho c_p / k_s.
TEST_P(Oscillator, BlockSettlesOnBaseSprings) {
  GroundParameters p = oscillator(Integrator::explicit_);
  p.base = Base::viscous;
  p.base_stiffness = 1e4;  // Pa/m, 1/6700 of the block's own
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  const auto load = pressure(ground, 1.0);
  const double constant = std::sqrt(modulus() * solid.density) / p.base_stiffness;
  for (int w = 0; w < 100; ++w) ground.advance(0.01 * constant, load);
  double mine = -1e300;
  for (const auto n : ground.own_top())
    mine = std::max(mine, -ground.top_state(n).displacement.z());
  const double expected = 1.0 / p.base_stiffness * (1 - std::exp(-1.0));
  const verified::Tolerance stiff{
      6e-4, "inertia, m k / c^2 = 1.5e-4, and compliance of the block, 1.5e-4, twice"};
  verified::near("settlement after one time constant", "m", Comm::world().max(mine), expected,
                 stiff.of(expected));
}

// The automatic springs G / depth carry a permanent load.
TEST_P(Oscillator, AutomaticBaseSpringsCarryALoad) {
  GroundParameters p = oscillator(Integrator::newmark);
  p.base = Base::viscous;
  p.base_stiffness = -1;
  double depth = 0;
  for (const Layer& layer : p.layers) depth += layer.thickness;
  const double spring = base_spring(p, solid, depth);
  EXPECT_NEAR(spring, solid.young / (2 * (1 + solid.poisson)) / depth, 1e-12 * spring);
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  const auto load = pressure(ground, 1.0);
  const double constant = std::sqrt(modulus() * solid.density) / spring;
  for (int w = 0; w < 400; ++w) ground.advance(0.05 * constant, load);
  double mine = -1e300;
  for (const auto n : ground.own_top())
    mine = std::max(mine, -ground.top_state(n).displacement.z());
  const double expected = 1.0 / spring + depth / modulus();  // springs and the block itself
  const verified::Tolerance decayed{
      1e-10, "decayed to 1e-14 after 20 time constants; solver: 1e-13 in each of 400 steps"};
  verified::near("settlement", "m", Comm::world().max(mine), expected, decayed.of(expected));
}

}  // namespace
}  // namespace trackbed::fem::oscillator_test
