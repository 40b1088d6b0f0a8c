// The ten-node tetrahedron alone: shape functions, rigid motions, constant stress, fractions of
// mass and load; and the forces of many against their matrices.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/kernel/stiffness.hpp"
#include "fem/shape/element.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/decompositions.hpp"
#include "unit/fem/mesh_scene.hpp"

namespace trackbed::fem::tetrahedra_test {
namespace {

constexpr double rounding = 1e-13;
constexpr Elastic solid{50e6, 0.3, 2000};

GroundParameters curved(const std::string& name) {
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {2, 2, 2};
  return of_mesh(TetBox(size, cells, shaken(size, cells, 0.08), TetBox::Edges::curved), name,
                 solid);
}

TEST(Tetrahedron, ShapeFunctionsAreOneAtTheirNode) {
  const TenNodes unit = {Vec3(0, 0, 0),     Vec3(1, 0, 0),     Vec3(0, 1, 0),   Vec3(0, 0, 1),
                         Vec3(0.5, 0, 0),   Vec3(0.5, 0.5, 0), Vec3(0, 0.5, 0), Vec3(0, 0, 0.5),
                         Vec3(0.5, 0, 0.5), Vec3(0, 0.5, 0.5)};
  for (int k = 0; k < 10; ++k) {
    TenNumbers one = TenNumbers::Zero();
    one[k] = 1;
    EXPECT_LT((tetrahedron_shape(unit[static_cast<std::size_t>(k)]) - one).norm(), rounding);
  }
  EXPECT_LT((tetrahedron_jacobian(unit, Vec3(0.1, 0.2, 0.3)) - Mat3::Identity()).norm(), rounding);
  EXPECT_NEAR(tetrahedron_volume(unit), 1.0 / 6, rounding);
  const TenNumbers load = tetrahedron_load(unit);
  EXPECT_NEAR(load[0], -1.0 / 120, rounding);
  EXPECT_NEAR(load[5], 1.0 / 30, rounding);
  double mass = 0;
  for (int k = 0; k < 10; ++k) mass += tetrahedron_mass_fraction(k);
  EXPECT_NEAR(mass, 1, rounding);
  for (int face = 0; face < 4; ++face) {  // counterclockwise seen from outside
    const auto& f = tetrahedron_faces[static_cast<std::size_t>(face)];
    const auto at = [&](std::size_t k) { return unit[static_cast<std::size_t>(f[k])]; };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0));
    EXPECT_GT(normal.dot(at(0) - Vec3::Constant(0.25)), 0);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LT((at(3 + k) - 0.5 * (at(k) + at((k + 1) % 3))).norm(), rounding);
  }
}

TEST(Tetrahedron, MeanRatioIsOneForEqualEdgesAndDecreasesWhenFlattened) {
  TenNodes nodes = {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
  EXPECT_NEAR(tetrahedron_mean_ratio(nodes), 1, rounding);
  for (Vec3& at : nodes) at.z() *= 1e-4;
  // Volume times 1e-4; of the six squared edges of 8 four become 4 and two are unchanged.
  EXPECT_NEAR(tetrahedron_mean_ratio(nodes), std::pow(1e-4, 2.0 / 3) * 48 / 32, 1e-9);
}

TEST(Tetrahedron, OnlyRigidMotionsAreFree) {
  const Mesh mesh(par::Comm::self(), curved("rigid"), Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  for (const std::size_t e : {0u, 7u, 20u}) {
    const Eigen::VectorXd values = symmetric_eigenvalues(stiffness.matrix(mesh, e));
    EXPECT_LT(std::abs(values(5)), 1e-12 * values(29));
    EXPECT_GT(values(6), 1e-4 * values(29));
  }
}

// The kernel against the matrices, and these against Hooke's law of the hexahedra.
TEST(Tetrahedra, ForcesAreThoseOfTheMatrices) {
  const Mesh mesh(par::Comm::self(), curved("forces"), Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  Nodal u(3, mesh.nodes()), f(3, mesh.nodes()), wanted(3, mesh.nodes());
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
      u[c][n] = 1e-3 * std::sin(1.3 * static_cast<double>(n) + c);
  stiffness.apply(u, f);
  double most = 0;
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    Eigen::VectorXd of(30);
    for (int k = 0; k < 30; ++k) of[k] = u[k % 3][mesh.corner(e, k / 3)];
    const Eigen::VectorXd force = stiffness.matrix(mesh, e) * of;
    for (int k = 0; k < 30; ++k) wanted[k % 3][mesh.corner(e, k / 3)] += force[k];
    most = std::max(most, force.cwiseAbs().maxCoeff());
  }
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) EXPECT_NEAR(f[c][n], wanted[c][n], 1e-12 * most);
}

TEST(Tetrahedra, LinearMotionIsConstantStress) {
  const Mesh mesh(par::Comm::self(), curved("constant"), Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  Mat3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -7e-4, 1e-4, 2e-4, 6e-4, 4e-4;
  Nodal u(3, mesh.nodes());
  for (std::size_t n = 0; n < mesh.nodes(); ++n) {
    const Vec3 at = gradient * mesh.position(static_cast<std::int32_t>(n));
    for (int c = 0; c < 3; ++c) u[c][n] = at[c];
  }
  const Mat3 e = 0.5 * (gradient + gradient.transpose());
  Vec6 strain;
  strain << e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0);
  const Vec6 exact = elasticity(solid) * strain;
  for (std::size_t z = 0; z < mesh.element.size(); ++z)
    for (const Vec3& xi : {tetrahedron_centre(), tetrahedron_face_centre(1)})
      EXPECT_LT((stiffness.tetrahedra().stress(z, xi, u) - exact).norm(), 1e-12 * exact.norm());
}

}  // namespace
}  // namespace trackbed::fem::tetrahedra_test
