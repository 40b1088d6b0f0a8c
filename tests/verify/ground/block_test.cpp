// Free vibration of a block: modes of a free cube and square, and of a cantilever.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "fem/boundary/terms.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/mesh.hpp"
#include "support/verified.hpp"
#include "trackbed/core/decompositions.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::block_test {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic solid{50e6, 0.3, 2000};
constexpr double edge = 1;  // m

// All squared angular frequencies of a free block of `elements` along each edge, ascending,
// rad^2/s^2. M^-1/2 K M^-1/2 column by column from the kernel: a few hundred unknowns.
Eigen::VectorXd squared_frequencies(Dimension dimension, std::int64_t elements, double* mass) {
  GroundParameters p = box({edge, edge, edge}, {elements, elements, elements}, solid);
  p.plane = PlaneState::strain;
  p.sides = Sides::free;
  Mesh mesh(Comm::self(), p, dimension, edge);
  std::vector<ElementMatrices> matrices = {
      element_matrices(mesh.lattice.size, solid, dimension, p.plane)};
  const Stiffness stiffness(mesh, matrices);
  const Terms terms(mesh, p, stiffness);
  const int d = mesh.lattice.components();
  const auto n = static_cast<Eigen::Index>(mesh.nodes());
  Eigen::MatrixXd k(d * n, d * n);
  Nodal u(d, mesh.nodes()), f(d, mesh.nodes());
  const auto root = [&](Eigen::Index node) {
    return std::sqrt(terms.mass[static_cast<std::size_t>(node)]);
  };
  for (int c = 0; c < d; ++c)
    for (Eigen::Index j = 0; j < n; ++j) {
      u[c][j] = 1;
      stiffness.apply(u, f);
      u[c][j] = 0;
      for (int e = 0; e < d; ++e)
        for (Eigen::Index i = 0; i < n; ++i) k(e * n + i, c * n + j) = f[e][i] / root(i) / root(j);
    }
  *mass = 0;
  for (const double m : terms.mass) *mass += m;
  return symmetric_eigenvalues(k);
}

class Block : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Block, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Lame's mode shears without changing volume and leaves all faces free of traction:
// u = (sin pi x cos pi z, 0, -cos pi x sin pi z) about a corner, omega = sqrt(2) pi c_s / edge.
TEST_P(Block, FreeVibration) {
  const bool plane = GetParam() == Dimension::plane;
  const double c_s = std::sqrt(solid.young / (2 * (1 + solid.poisson)) / solid.density);
  const double exact = std::sqrt(2.0) * pi * c_s / edge;  // rad/s
  std::vector<double> error;
  double mass = 0;
  const verified::Limit rounding{
      2e-11, "rounding: 1e-16 of the largest, 400 times Lame's, of 600 frequencies squared"};
  // In space a third level would take minutes.
  const std::vector<int> levels = plane ? std::vector{8, 16, 24} : std::vector{3, 6};
  for (const std::int64_t elements : levels) {
    const Eigen::VectorXd squared = squared_frequencies(GetParam(), elements, &mass);
    // The mode nearest to Lame's; six (three) rigid motions have frequency zero.
    double nearest = 0;
    for (const double s : squared)
      if (std::abs(std::sqrt(std::abs(s)) - exact) < std::abs(nearest - exact))
        nearest = std::sqrt(std::abs(s));
    error.push_back(nearest / exact - 1);
    const Eigen::Index rigid = plane ? 3 : 6;
    const std::string which = fmt::format(", {} elements an edge", elements);
    verified::below("rigid motions: largest frequency squared over Lame's" + which, "-",
                    squared.head(rigid).cwiseAbs().maxCoeff() / (exact * exact), rounding);
    verified::above("first frequency of deformation over Lame's" + which, "-",
                    std::sqrt(squared[rigid]) / exact,
                    {0.5, "separates modes of deformation from rigid motions, which have 0"});
  }
  // Half a wave along an edge, k = pi. Lumped masses lower it by (k h)^2 / 24, strains that are
  // constant across an element by up to twice as much.
  const verified::Tolerance flat{0.0025, "mesh: (k h)^2 / 8, k h = pi / 24"};
  const verified::Tolerance solid_block{0.012, "mesh: (k h)^2 / 24, k h = pi / 6"};
  verified::near("frequency of Lame's mode over the exact one", "-", 1 + error.back(), 1,
                 plane ? flat : solid_block);
  // With four elements in a plane another mode is nearer.
  const verified::Tolerance order{0.3, "second order; next term (k h)^2 = 0.15 with 8 elements"};
  for (std::size_t i = 1; i < levels.size(); ++i)
    verified::near(fmt::format("order of its error, {} to {} elements", levels[i - 1], levels[i]),
                   "-",
                   std::log(error[i - 1] / error[i]) /
                       std::log(static_cast<double>(levels[i]) / levels[i - 1]),
                   2, order);
  verified::near("mass", "kg", mass, solid.density * edge * edge * edge,
                 {1e-10, "rounding of a sum of 300 parts, 1e-13 kg each, three times"});
}

// First frequency of a cantilever with shear and rotary inertia, rad/s (Timoshenko 1921; Huang
// 1961, doi:10.1115/1.3641787): zero of the determinant of its four end conditions. kappa = 5/6.
double timoshenko(double length, double height) {
  const double ei = solid.young * std::pow(height, 3) / 12, mass = solid.density * height;
  const double shear = 5.0 / 6 * height * solid.young / (2 * (1 + solid.poisson));
  const auto determinant = [&](double omega) {
    const double b2 = mass * omega * omega * std::pow(length, 4) / ei;
    const double r2 = height * height / 12 / (length * length), s2 = ei / (shear * length * length);
    const double root = std::sqrt((r2 - s2) * (r2 - s2) + 4 / b2);
    const double b = std::sqrt(b2), alpha = std::sqrt(0.5 * (-(r2 + s2) + root)),
                 beta = std::sqrt(0.5 * (r2 + s2 + root));
    return 2 + (b2 * (r2 - s2) * (r2 - s2) + 2) * std::cosh(b * alpha) * std::cos(b * beta) -
           b * (r2 + s2) / std::sqrt(1 - b2 * r2 * s2) * std::sinh(b * alpha) * std::sin(b * beta);
  };
  double low = 0.5, high = 1.1 * 3.5160 * std::sqrt(ei / mass) / (length * length);
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (determinant(middle) * determinant(low) > 0 ? low : high) = middle;
  }
  return low;
}

// Released from the shape under a lateral force, it vibrates in its first mode.
TEST(Cantilever, VibratesWithTheFrequencyOfABeam) {
  constexpr double length = 10, height = 1;
  GroundParameters p = box({height, 1, length}, {4, 1, 40}, solid);
  p.plane = PlaneState::stress;
  p.base = Base::fixed;
  p.sides = Sides::free;
  Ground ground(Comm::world(), p, Dimension::plane, 1.0);
  std::vector<Vec3> load(ground.top().nodes(), Vec3::Zero()), none = load;
  for (std::size_t n = 0; n < load.size() / 2; ++n) load[n].x() = 20;
  const double omega = timoshenko(length, height), period = 2 * pi / omega;
  // A force over half a period mainly excites the first mode; then free. Fit of velocity zeros.
  constexpr int windows = 400;
  const double dt = period / windows;
  std::vector<double> crossings;
  double before = 0;
  for (int w = 0; w < 6 * windows; ++w) {
    ground.advance(dt, w < windows / 2 ? load : none);
    double mine = -1e300;
    for (const auto n : ground.own_top())
      if (n == 0) mine = ground.top_state(n).displacement.x();
    const double u = Comm::world().max(mine);
    if (w > windows / 2 && before < 0 && u >= 0) crossings.push_back(w - u / (u - before));
    before = u;
  }
  ASSERT_GE(crossings.size(), 4u);
  const double measured =
      (crossings.back() - crossings.front()) * dt / static_cast<double>(crossings.size() - 1);
  const verified::Tolerance clamp{
      0.01, "the clamp prevents lateral strain: shorter by 0.05 of the height, 1 % of the period"};
  verified::near("period of the first mode", "s", measured, period, clamp.of(period));
}

}  // namespace
}  // namespace trackbed::fem::block_test
