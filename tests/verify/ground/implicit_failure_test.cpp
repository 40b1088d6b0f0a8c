// Failure of grounds in implicit steps: triaxial strength in few long steps, and the order of
// convergence of Newton's method. The strip footing is in failure_test.cpp.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/kernel/plastic_step.hpp"
#include "support/verified.hpp"
#include "unit/fem/yielding_scene.hpp"

namespace trackbed::fem::implicit_failure_test {
namespace {

using par::Comm;

class ImplicitFailure : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, ImplicitFailure, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// An element compressed by `axial` in ten steps with a search for the lateral strain that keeps the
// pressure. Returns the axial stress, Pa, pressure positive. In a plane y is fixed.
double triaxial(const Elastic& solid, const Strength& strength, Dimension dimension,
                double pressure) {
  GroundParameters p = box({1, 1, 1}, {1, 1, 1}, solid);
  p.layers[0].strength = strength;
  const Mesh mesh(Comm::self(), p, dimension, 1.0);
  Plasticity plasticity(mesh);
  PlasticStep step(mesh, plasticity);
  const ElementMatrices element =
      element_matrices(mesh.lattice.size, solid, dimension, PlaneState::strain);
  const int parts = mesh.lattice.components(), corners = mesh.lattice.corners();
  const Nodal none(parts, mesh.nodes());
  Nodal u = none;
  Vec6 stress = Vec6::Zero();
  const auto move = [&](const Vec3& strain) {
    Eigen::VectorXd flat(parts * corners);
    for (int k = 0; k < corners; ++k)
      for (int c = 0; c < parts; ++c) {
        const std::int32_t n = mesh.corner(0, k);
        const int axis = mesh.lattice.axis(c);
        u[c][n] =
            strain[axis] * mesh.lattice.position(mesh.node[static_cast<std::size_t>(n)])[axis];
        flat(parts * k + c) = u[c][n];
      }
    step.flow(none, u);
    stress = element.centre_stress * flat +
             plasticity.stress(0, Plasticity::Where::centre, Plasticity::When::since);
  };
  Vec3 strain = Vec3::Zero();
  for (int n = 1; n <= 10; ++n) {
    strain.z() = -0.003 * n;
    // Secants, as the yielding solid is laterally much softer than the elastic one.
    for (int k = 0; k < 2000; ++k) {
      move(strain);
      const double lack = stress(0) + pressure;
      if (std::abs(lack) < 1e-9 * pressure + 1e-6) break;
      strain.x() -= lack / (1.5 * solid.young);
      if (dimension == Dimension::space) strain.y() = strain.x();
    }
    step.keep(u);
  }
  return -stress(2);
}

TEST_P(ImplicitFailure, TriaxialStrength) {
  for (const auto& [cohesion, friction, dilation] : std::array{
           std::array{20e3, 30.0, 10.0}, std::array{20e3, 40.0, 0.0}, std::array{50e3, 0.0, 0.0}}) {
    const Strength strength{Yield::mohr_coulomb, cohesion, friction, dilation, 10e3};
    const double sine = std::sin(friction * std::numbers::pi / 180), n = (1 + sine) / (1 - sine);
    const double exact = n * 50e3 + 2 * cohesion * std::sqrt(n);
    const verified::Tolerance search{1e-9, "search for the lateral pressure: N 1e-9 of it"};
    verified::near(
        fmt::format("strength, c {:g} kPa, phi {:g}, at 50 kPa", cohesion / 1e3, friction), "Pa",
        triaxial({50e6, 0.3, 2000}, strength, GetParam(), 50e3), exact, search.of(exact));
  }
}

// Half of a strip of half width 1 m on weightless clay, whose pressure rises to 0.85 of Prandtl's
// in 0.1 s and then is constant: settlement of the centre after 0.15 s, m.
double settlement(const Comm& comm, Integrator integrator) {
  const double cohesion = 50e3, rise = 0.1, end = 0.15;
  GroundParameters p = box({5, 1, 2.5}, {20, 1, 10}, {50e6, 0.3, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.rayleigh_mass = 20;
  p.integrator = integrator;
  p.layers[0].strength = {Yield::mohr_coulomb, cohesion, 0, 0, 1e3 * cohesion};
  Ground ground(comm, p, Dimension::plane, 1.0);
  std::vector<Vec3> unit(ground.top().nodes(), Vec3::Zero());  // N of 1 Pa; two faces
  for (std::size_t n = 0; n < unit.size(); ++n) {
    const double x = ground.top().position[n].x();
    if (x < 1.01) unit[n].z() = -0.5 * 0.25 * (x < 0.01 || x > 0.99 ? 0.5 : 1);
  }
  // A wave crosses the model in 14 ms.
  const int windows = integrator == Integrator::explicit_ ? 1500 : 75;
  const double dt = end / windows;
  for (int w = 0; w < windows; ++w) {
    auto force = unit;
    for (Vec3& each : force)
      each *= 0.85 * (2 + std::numbers::pi) * cohesion * std::min((w + 1) * dt / rise, 1.0);
    ground.advance(dt, force);
  }
  double found = 0;
  for (const std::int32_t n : ground.own_top())
    found = std::max(found, -ground.top_state(n).displacement.z());
  return comm.max(found);
}

// Implicit steps of 2 ms, windows of 0.1 ms.
TEST(ImplicitFooting, SettlesAsInExplicitSteps) {
  const Comm comm = Comm::world();
  const double exact = settlement(comm, Integrator::explicit_);
  verified::near("settlement of a strip, newmark over explicit", "-",
                 settlement(comm, Integrator::newmark) / exact, 1,
                 {0.01, "steps of 2 ms: (omega dt)^2 / 12 = 7 % of waves of 14 ms, a tenth of it"});
}

// Order two: the residual of an iteration over the square of the one before is bounded. Residuals
// relative to the forces of the step, from below 0.1 to where the square is rounding. First order
// would give 1e4.
TEST_P(ImplicitFailure, NewtonIsOfSecondOrder) {
  GroundParameters p = yielding_scene();
  p.integrator = Integrator::newmark;
  p.tolerance = 1e-13;
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  ground.settle(settled(ground.top()));
  double ratio = 0, count = 0, most = 0;
  for (int w = 0; w < 12; ++w) {
    ground.advance(5e-4, load_of(ground.top(), w));
    const GroundTotals totals = ground.totals();
    const std::vector<double>& left = totals.newton_residuals;
    most = std::max(most, static_cast<double>(left.size()) - 1);
    for (std::size_t k = 1; k < left.size(); ++k)
      if (left[k - 1] < 0.1 && left[k - 1] > 1e-5) {
        ratio = std::max(ratio, left[k] / (left[k - 1] * left[k - 1]));
        ++count;
      }
  }
  ASSERT_GT(count, 12);
  verified::below("largest residual of an iteration over the square of the one before", "-", ratio,
                  {1.25, "second order: about 1; first order: 1e4"});
  verified::above("the same from below", "-", ratio,
                  {0.1, "separates: the step is not linear, which has 0, nor of third order"});
  verified::below("most iterations in a step", "-", most,
                  {6, "second order from 0.1 to 1e-13: 0.1, 1e-2, 1e-4, 1e-8, 1e-16"});
}

}  // namespace
}  // namespace trackbed::fem::implicit_failure_test
