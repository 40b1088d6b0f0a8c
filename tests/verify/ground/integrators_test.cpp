// Implicit integrators on an oscillator of one degree of freedom (reference case "Integrators"):
// spectral radius and period error at dt/T = 0.1, and second order for any numerical damping.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::integrators_test {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic solid{50e6, 0.3, 2000};
const double modulus = solid.young * 0.7 / (1.3 * 0.4);  // Pa, constrained, nu = 0.3
const double omega = std::sqrt(2 * modulus / solid.density), period = 2 * pi / omega;

struct Scheme {
  const char* name;
  Integrator integrator;
  double alpha, rho_inf;        // parameter of the scheme
  double radius, period_error;  // at dt/T = 0.1, to the digits given
};

GroundParameters oscillator(const Scheme& scheme) {
  GroundParameters p = box({1, 1, 1}, {1, 1, 1}, solid);
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.integrator = scheme.integrator;
  p.alpha = scheme.alpha, p.rho_inf = scheme.rho_inf;
  p.tolerance = 1e-13;
  return p;
}

// Displacement of the top under a pressure of time, window after window.
template <class Pressure>
std::vector<double> swing(const GroundParameters& p, double dt, int windows, Pressure pressure_at) {
  Ground ground(Comm::world(), p, Dimension::plane, 1.0);
  const auto unit = pressure(ground, 1.0);
  auto load = unit;
  std::vector<double> u;
  for (int w = 1; w <= windows; ++w) {
    for (std::size_t n = 0; n < load.size(); ++n) load[n] = pressure_at(w * dt) * unit[n];
    ground.advance(dt, load);
    double mine = -1e300;
    for (const auto n : ground.own_top())
      mine = std::max(mine, ground.top_state(n).displacement.z());
    u.push_back(Comm::world().max(mine));
  }
  return u;
}

class Integrators : public ::testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(
    , Integrators,
    ::testing::Values(Scheme{"newmark", Integrator::newmark, 0, 0, 1, 0.03207},
                      Scheme{"bossak", Integrator::bossak, -0.3, 0, 0.993429, 0.05917},
                      Scheme{"hht", Integrator::hht, -0.1, 0, 0.998728, 0.03951},
                      Scheme{"generalized_alpha", Integrator::generalized_alpha, 0, 0.8, 0.999904,
                             0.03383}),
    [](const auto& p) { return std::string(p.param.name); });

// The pair of roots rho exp(+-i W) of the amplification matrix satisfies
//   u_(n+1) = 2 rho cos(W) u_n - rho^2 u_(n-1)
// about the static displacement; the third root, below 0.3 here, has decayed after 30 steps. Both
// numbers from a least-squares fit.
TEST_P(Integrators, SpectralRadiusAndPeriodError) {
  const Scheme& scheme = GetParam();
  auto u = swing(oscillator(scheme), 0.1 * period, 130, [](double) { return 1e3; });
  for (double& value : u) value += 1e3 / modulus;
  double aa = 0, ab = 0, bb = 0, ac = 0, bc = 0;
  for (std::size_t n = 31; n + 1 < u.size(); ++n) {
    aa += u[n] * u[n], ab += u[n] * u[n - 1], bb += u[n - 1] * u[n - 1];
    ac += u[n] * u[n + 1], bc += u[n - 1] * u[n + 1];
  }
  const double all = aa * bb - ab * ab;
  const double sum = (ac * bb - bc * ab) / all, product = (aa * bc - ab * ac) / all;
  const double radius = std::sqrt(-product), phase = std::acos(0.5 * sum / radius);
  verified::near("spectral radius at dt/T = 0.1", "-", radius, scheme.radius,
                 {6e-7, "six digits of the reference"});
  verified::near("period error at dt/T = 0.1", "-", 0.2 * pi / phase - 1, scheme.period_error,
                 {6e-6, "five digits of the reference"});
}

// A pressure that rises smoothly: loads of two windows are weighted as the motion is.
TEST_P(Integrators, SecondOrderUnderAChangingLoad) {
  const auto p = oscillator(GetParam());
  const auto at_end = [&](int windows) {
    return swing(p, 1.5 * period / windows, windows,
                 [](double t) { return 1e3 * std::pow(std::sin(0.5 * omega * t), 4); })
        .back();
  };
  const double coarse = at_end(60), middle = at_end(120), fine = at_end(240);
  verified::near("order", "-", std::log2((coarse - middle) / (middle - fine)), 2,
                 {0.1, "second order; next term omega dt = 0.16 at the coarsest, halved"});
}

}  // namespace
}  // namespace trackbed::fem::integrators_test
