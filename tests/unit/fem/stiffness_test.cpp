// The matrix-free force against element matrices, and its mesh.
#include "fem/kernel/stiffness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "fem/mesh/mesh.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::stiffness_test {
namespace {

using par::Comm;

GroundParameters two_layers(std::int64_t nx) {
  GroundParameters p = box({2, 1.5, 1}, {nx, 3, 4}, {50e6, 0.3, 2000});
  p.layers = {{"a", 0.4, {120e6, 0.2, 1900}}, {"b", 0.6, {60e6, 0.45, 1700}}};
  p.blocks = {{"c", true, {0.5, 0, 1.1, 0, 0.8, -1}, {1e9, 0.25, 2500}}};
  return p;
}

// The modulus of layer b rises and falls along x, over a plateau.
GroundParameters with_table(std::int64_t nx) {
  GroundParameters p = two_layers(nx);
  p.layers[1].young_file =
      "stiffness_" + std::to_string(Comm::world().size()) + std::to_string(Comm::world().rank());
  std::ofstream(p.layers[1].young_file) << "x_m,young_Pa\n0,6e7\n0.6,3e9\n1.2,3e9\n2,1e8\n";
  return p;
}

class Kernel : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Kernel, ::testing::Values(Dimension::plane, Dimension::space));

// Row lengths around the vector width and the longest run, so that every remainder occurs;
// negative: with moduli from a table.
TEST_P(Kernel, ForceIsThatOfTheElementMatrices) {
  for (const std::int64_t number : {1, 7, 8, 9, 16, 63, 64, 65, 131, -7, -9, -64, -131}) {
    const std::int64_t nx = std::abs(number);
    Mesh mesh(Comm::world(), number > 0 ? two_layers(nx) : with_table(nx), GetParam(), 1.0);
    std::vector<ElementMatrices> elements;
    for (const Elastic& s : mesh.solids.solid)
      elements.push_back(element_matrices(mesh.lattice.size, s, GetParam(), PlaneState::stress));
    const Stiffness stiffness(mesh, elements);
    const int d = mesh.lattice.components();
    Nodal u(d, mesh.nodes()), f(d, mesh.nodes()), expected(d, mesh.nodes());
    for (int c = 0; c < d; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n)
        u[c][n] = std::sin(0.37 * static_cast<double>(mesh.node[n]) + 1.3 * c);
    stiffness.apply(u, f);
    for (std::size_t z = 0; z < mesh.element.size(); ++z) {
      const auto& k = elements[static_cast<std::size_t>(mesh.solid[z])].stiffness;
      for (int a = 0; a < k.rows(); ++a)
        for (int b = 0; b < k.cols(); ++b)
          expected[a % d][mesh.corner(z, a / d)] += k(a, b) * u[b % d][mesh.corner(z, b / d)];
    }
    double error = 0, size = 0;
    for (int c = 0; c < d; ++c)
      for (const auto n : mesh.own) {
        error = std::max(error, std::abs(f[c][n] - expected[c][n]));
        size = std::max(size, std::abs(expected[c][n]));
      }
    EXPECT_LE(error, 1e-12 * size) << number;  // rounding of sums of a few dozen terms
  }
}

TEST_P(Kernel, RigidShiftGivesNoForceAtAll) {
  Mesh mesh(Comm::world(), two_layers(11), GetParam(), 1.0);
  std::vector<ElementMatrices> elements;
  for (const Elastic& s : mesh.solids.solid)
    elements.push_back(element_matrices(mesh.lattice.size, s, GetParam(), PlaneState::strain));
  const Stiffness stiffness(mesh, elements);
  Nodal u(mesh.lattice.components(), mesh.nodes()), f = u;
  u.fill(0.123);
  stiffness.apply(u, f);
  for (int c = 0; c < mesh.lattice.components(); ++c)
    for (const auto n : mesh.own) EXPECT_EQ(f[c][n], 0);
}

TEST(Mesh, SolidsFollowLayersAndBlocks) {
  const GroundParameters p = two_layers(4);
  EXPECT_EQ(region_at(p, {1.9, 0, -0.39}), 0);
  EXPECT_EQ(region_at(p, {1.9, 0, -0.41}), 1);
  EXPECT_EQ(region_at(p, {0.8, 0, -0.2}), 2);
  EXPECT_EQ(region_at(p, {0.55, 0, -0.9}), 1);  // beside the tip of the wedge
  GroundParameters without = p;
  without.blocks[0].present = false;
  EXPECT_EQ(region_at(without, {0.8, 0, -0.2}), 0);
  GroundParameters twice = p;
  twice.blocks.push_back({"d", true, {0, 0, 2, 0, 2, -0.3, 0, -0.3}, {}});
  EXPECT_EQ(region_at(twice, {0.8, 0, -0.2}), 3);  // the later one has priority
}

TEST_P(Kernel, EveryNodeHasOneOwnerAndGhostsFollowIt) {
  Mesh mesh(Comm::world(), two_layers(12), GetParam(), 1.0);
  const auto own = static_cast<std::int64_t>(mesh.own.size());
  EXPECT_EQ(mesh.comm.sum(own), mesh.lattice.node_count());
  Nodal values(mesh.lattice.components(), mesh.nodes());
  for (const auto n : mesh.own)
    for (int c = 0; c < mesh.lattice.components(); ++c)
      values[c][n] = static_cast<double>(10 * mesh.node[static_cast<std::size_t>(n)] + c);
  mesh.exchange(values);
  for (std::size_t n = 0; n < mesh.nodes(); ++n)
    for (int c = 0; c < mesh.lattice.components(); ++c)
      EXPECT_EQ(values[c][n], static_cast<double>(10 * mesh.node[n] + c));
}

}  // namespace
}  // namespace trackbed::fem::stiffness_test
