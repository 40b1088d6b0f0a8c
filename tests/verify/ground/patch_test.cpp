// Patch test: distorted hexahedra with a common inner node, under a linear motion of the outer
// nodes. The inner node must follow it, and all stresses must be constant.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fem/shape/element.hpp"
#include "support/verified.hpp"

namespace trackbed::fem::patch_test {
namespace {

// A cube of 2 x 2 x 2 elements; the nodes of its faces and the inner one are displaced so that no
// element has two parallel faces.
struct Patch {
  Patch() {
    for (int n = 0; n < 27; ++n) {
      const Vec3 home(0.5 * (n % 3), 0.5 * (n / 3 % 3), 0.5 * (n / 9));
      Vec3 at = home;
      // Corners of the cube are not moved.
      const bool corner = n % 3 != 1 && n / 3 % 3 != 1 && n / 9 != 1;
      for (int a = 0; a < 3 && !corner; ++a) at[a] += 0.09 * std::sin(2.3 * n + 1.9 * a + 0.4);
      position.push_back(at);
    }
    for (int e = 0; e < 8; ++e) {
      std::array<int, 8> nodes{};
      for (int k = 0; k < 8; ++k)
        nodes[static_cast<std::size_t>(k)] =
            (e & 1) + (k & 1) + 3 * ((e >> 1 & 1) + (k >> 1 & 1)) + 9 * ((e >> 2) + (k >> 2));
      elements.push_back(nodes);
    }
  }
  std::vector<Vec3> position;
  std::vector<std::array<int, 8>> elements;
};
constexpr int inside = 13;

TEST(Patch, DistortedHexahedraKeepConstantStress) {
  const Patch patch;
  Mat3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -7e-4, 1e-4, 2e-4, 6e-4, 4e-4;
  const Mat3 e = 0.5 * (gradient + gradient.transpose());
  Eigen::Matrix<double, 6, 1> strain;
  strain << e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0);
  const verified::Limit rounding{1e-12,
                                 "rounding times the condition, 1 / (1 - 2 nu) = 5000, twice"};
  for (const double nu : {0.3, 0.4999}) {
    const Voigt d = elasticity({100e6, nu, 2000});
    std::vector<Hexahedron> solids;
    for (const auto& nodes : patch.elements) {
      Corners corners;
      for (std::size_t k = 0; k < 8; ++k)
        corners[k] = patch.position[static_cast<std::size_t>(nodes[k])];
      solids.emplace_back(corners, d);
    }
    std::vector<Vec3> u;
    for (const Vec3& x : patch.position) u.push_back(gradient * x);
    const Vec3 exact = u[inside];
    u[inside].setZero();
    // Force on the inner node and its stiffness: three equations.
    const auto motion = [&](std::size_t element) {
      Eigen::Matrix<double, 24, 1> all;
      for (int k = 0; k < 8; ++k)
        all.segment<3>(3 * k) =
            u[static_cast<std::size_t>(patch.elements[element][static_cast<std::size_t>(k)])];
      return all;
    };
    Mat3 stiffness = Mat3::Zero();
    Vec3 force = Vec3::Zero();
    for (std::size_t s = 0; s < solids.size(); ++s)
      for (int k = 0; k < 8; ++k)
        if (patch.elements[s][static_cast<std::size_t>(k)] == inside) {
          stiffness += solids[s].stiffness().block<3, 3>(3 * k, 3 * k);
          force += (solids[s].stiffness() * motion(s)).segment<3>(3 * k);
        }
    u[inside] = -stiffness.inverse() * force;
    verified::below(fmt::format("error of the inner node over its displacement, nu = {:g}", nu),
                    "-", (u[inside] - exact).norm() / exact.norm(), rounding);
    double most = 0;
    for (std::size_t s = 0; s < solids.size(); ++s)
      for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0.5, -0.7, 0.9)})
        most = std::max(most, (solids[s].stress(at) * motion(s) - d * strain).norm());
    verified::below(fmt::format("error of stresses over the exact one, nu = {:g}", nu), "-",
                    most / (d * strain).norm(), rounding);
  }
}

}  // namespace
}  // namespace trackbed::fem::patch_test
