// A single hexahedron: patch test on distorted elements, rigid motions, bending, incompressibility.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/shape/element.hpp"
#include "trackbed/core/decompositions.hpp"

namespace trackbed::fem::hexahedron_test {
namespace {

// Rounding of a 24x24 stiffness relative to its largest entry.
constexpr double rounding = 1e-12;

Corners brick(const Vec3& size) {
  Corners corners;
  for (int k = 0; k < 8; ++k)
    corners[static_cast<std::size_t>(k)] = Vec3(k & 1, k >> 1 & 1, k >> 2 & 1).cwiseProduct(size);
  return corners;
}

// Corner displacements of a brick that keep it convex and skew every face.
Corners skewed() {
  Corners corners = brick({1.0, 1.2, 0.8});
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a)
      corners[static_cast<std::size_t>(k)][a] += 0.15 * std::sin(3.1 * k + 1.7 * a);
  return corners;
}

Eigen::Matrix<double, 24, 1> motion(const Corners& corners, const Mat3& gradient,
                                    const Vec3& shift) {
  Eigen::Matrix<double, 24, 1> u;
  for (int k = 0; k < 8; ++k)
    u.segment<3>(3 * k) = gradient * corners[static_cast<std::size_t>(k)] + shift;
  return u;
}

TEST(Hexahedron, RigidMotionsAreFreeAndSixInNumber) {
  const Hexahedron element(skewed(), elasticity({100e6, 0.3, 2000}));
  const auto& k = element.stiffness();
  Mat3 turn;
  turn << 0, -0.3, 0.2, 0.3, 0, -0.5, -0.2, 0.5, 0;
  const double largest = k.cwiseAbs().maxCoeff();
  EXPECT_LT((k * motion(skewed(), turn, {1, 2, 3})).cwiseAbs().maxCoeff(), 10 * rounding * largest);
  const Eigen::VectorXd values = symmetric_eigenvalues(k);
  EXPECT_LT(std::abs(values(5)), rounding * values(23));
  EXPECT_GT(values(6), 1e-3 * values(23));  // no spurious zero-energy mode
}

// Linear displacement gives the constant stress exactly, for any shape.
TEST(Hexahedron, DistortedElementHasConstantStress) {
  const Voigt d = elasticity({100e6, 0.3, 2000});
  const Hexahedron element(skewed(), d);
  Mat3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -7e-4, 1e-4, 2e-4, 6e-4, 4e-4;
  const auto u = motion(skewed(), gradient, {0.1, 0, 0});
  Eigen::Matrix<double, 6, 1> strain;
  const Mat3 e = 0.5 * (gradient + gradient.transpose());
  strain << e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0);
  const Eigen::Matrix<double, 6, 1> exact = d * strain;
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0.5, -0.7, 0.9)})
    EXPECT_LT((element.stress(at) * u - exact).norm(), 1e3 * rounding * exact.norm());
}

// Energy patch test: two distorted elements with a common face under prescribed linear motion
// outside have no net force on the nodes of the common face from the stress jump.
TEST(Hexahedron, DistortedPatchIsInEquilibrium) {
  Corners left = brick({1, 1, 1}), right = brick({1, 1, 1});
  for (int k = 0; k < 8; ++k) right[static_cast<std::size_t>(k)].x() += 1;
  for (int k = 1; k < 8; k += 2) {  // skew the shared face
    const Vec3 move(0.1 * std::sin(k), 0.05 * std::cos(2.0 * k), 0.08 * std::sin(4.0 * k));
    left[static_cast<std::size_t>(k)] += move;
    right[static_cast<std::size_t>(k - 1)] += move;
  }
  const Voigt d = elasticity({100e6, 0.49, 2000});
  const Hexahedron a(left, d), b(right, d);
  // Uniaxial stress, free along y and z: only the x faces are loaded, so the common face balances.
  Mat3 gradient = Vec3(1e-3, -0.49e-3, -0.49e-3).asDiagonal();
  const auto fa = (a.stiffness() * motion(left, gradient, Vec3::Zero())).eval();
  const auto fb = (b.stiffness() * motion(right, gradient, Vec3::Zero())).eval();
  const double scale = fa.cwiseAbs().maxCoeff();
  for (int k = 1; k < 8; k += 2)
    EXPECT_LT((fa.segment<3>(3 * k) + fb.segment<3>(3 * (k - 1))).norm(), 1e-9 * scale) << k;
}

// One brick in pure bending, u_x = x z: exact strain energy 1/2 E I L / rho^2, also for nu -> 1/2.
TEST(Hexahedron, BendsWithoutLocking) {
  const Vec3 size(2.0, 0.5, 0.4);
  for (const double nu : {0.0, 0.3, 0.49, 0.4999}) {
    const double young = 70e9;
    const Hexahedron element(brick(size), elasticity({young, nu, 2700}));
    // Only the linear part x z of u_x is prescribed; the others relax: energy by condensation.
    Eigen::Matrix<double, 24, 1> u = Eigen::Matrix<double, 24, 1>::Zero();
    const double curvature = 1e-3;
    for (int k = 0; k < 8; ++k) {
      const double x = ((k & 1) - 0.5) * size.x(), z = ((k >> 2 & 1) - 0.5) * size.z();
      const double y = ((k >> 1 & 1) - 0.5) * size.y();
      u(3 * k) = curvature * x * z;
      u(3 * k + 1) = -nu * curvature * y * z;  // anticlastic; the rest is enhanced
    }
    const double inertia = size.y() * std::pow(size.z(), 3) / 12;
    const double exact = 0.5 * young * inertia * curvature * curvature * size.x();
    const double energy = 0.5 * u.dot(element.stiffness() * u);
    EXPECT_NEAR(energy / exact, 1, 1e-9) << "nu " << nu;
  }
}

// Near incompressibility only the volume mode may be stiff: one large eigenvalue, not more.
TEST(Hexahedron, OnlyOneModeStiffensWhenIncompressible) {
  const Hexahedron element(brick({1, 1, 1}), elasticity({1.0, 0.4999, 1}));
  const Eigen::VectorXd values = symmetric_eigenvalues(element.stiffness());
  EXPECT_GT(values(23), 100);
  EXPECT_LT(values(22), 2);
}

TEST(ElementMatrices, PlaneStressStretchesByYoungsModulus) {
  const Elastic solid{200e9, 0.3, 7800};
  const Vec3 size(0.5, 0.1, 0.25);
  const ElementMatrices element =
      element_matrices(size, solid, Dimension::plane, PlaneState::stress);
  Eigen::VectorXd u(8);
  for (int k = 0; k < 4; ++k) {
    u(2 * k) = 1e-3 * ((k & 1) != 0 ? size.x() : 0);
    u(2 * k + 1) = -0.3e-3 * ((k >> 1) != 0 ? size.z() : 0);
  }
  const Eigen::VectorXd stress = element.centre_stress * u;
  EXPECT_NEAR(stress(0), 200e6, 1);
  EXPECT_NEAR(stress(1), 0, 1);
  EXPECT_NEAR(stress(2), 0, 1);
  const ElementMatrices strain =
      element_matrices(size, solid, Dimension::plane, PlaneState::strain);
  EXPECT_GT(std::abs((strain.centre_stress * u)(1)), 1e6);
}

}  // namespace
}  // namespace trackbed::fem::hexahedron_test
