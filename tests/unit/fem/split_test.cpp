// The partition follows the cost of elements: yielding ones, and those below the stones.
#include "fem/mesh/split.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "fem/mesh/boxes.hpp"
#include "fem/mesh/mesh.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::split_test {
namespace {

// Cuts are between layers of elements, of METIS with a tolerance of 3 %; nodes between two ranks
// belong to the lower one.
constexpr double uneven = 1.12;

// Elements written by this rank, which are its own except at borders: largest fraction over the
// mean. Collective.
double worst_fraction(const Mesh& mesh, const std::function<double(std::size_t element)>& cost) {
  double mine = 0;
  for (std::size_t z = 0; z < mesh.element.size(); ++z)
    if (mesh.writes(z)) mine += cost(z);
  return mesh.comm.max(mine) * mesh.comm.size() / mesh.comm.sum(mine);
}

Block soft_half(double length, double depth) {
  const double half = length / 2;
  Block soft{"soft", true, {0, 0, half, 0, half, -depth, 0, -depth}, {20e6, 0.3, 1900}};
  soft.strength = {Yield::mohr_coulomb, 20e3, 0, 0, 5e3};
  return soft;
}

const Strength& strength_of(const Mesh& mesh, std::size_t z) {
  return mesh.solids.strength[static_cast<std::size_t>(mesh.solid[z])];
}

// Of cost 3 in the lower half and 1 above, with sides that no power of two divides.
TEST(Boxes, ContainEachElementOnceAndAreEven) {
  const par::Comm comm = par::Comm::world();
  const Index3 elements{50, 14, 22};
  const auto cost = [](const Index3& at) { return at[2] < 11 ? 3.0 : 1.0; };
  const Boxes boxes(comm, elements, cost);
  double mine = 0, all = 0;
  std::int64_t in_boxes = 0;
  for (int rank = 0; rank < comm.size(); ++rank) in_boxes += boxes.box_of(rank).size();
  EXPECT_EQ(in_boxes, elements[0] * elements[1] * elements[2]);
  Index3 at;
  for (at[2] = 0; at[2] < elements[2]; ++at[2])
    for (at[1] = 0; at[1] < elements[1]; ++at[1])
      for (at[0] = 0; at[0] < elements[0]; ++at[0]) {
        const int rank = boxes.rank_of(at);
        const IndexBox& box = boxes.box_of(rank);
        for (std::size_t a = 0; a < 3; ++a)
          ASSERT_TRUE(box.begin[a] <= at[a] && at[a] < box.end[a]);
        all += cost(at), mine += rank == comm.rank() ? cost(at) : 0;
      }
  EXPECT_LT(comm.max(mine) * comm.size() / all, 1.06);
}

// Of two elements two ranks have one each, and others none.
TEST(Boxes, FewElementsLeaveRanksEmpty) {
  const par::Comm comm = par::Comm::world();
  const Boxes boxes(comm, {1, 1, 2}, [](const Index3&) { return 1.0; });
  const std::int64_t own = boxes.box_of(comm.rank()).size();
  EXPECT_EQ(comm.sum(own), 2);
  EXPECT_EQ(comm.max(own), comm.size() > 1 ? 1 : 2);
}

TEST(Split, YieldingElementsHaveALargerWeight) {
  GroundParameters p = box({24, 2, 2}, {96, 8, 8}, {80e6, 0.3, 1900});
  p.blocks = {soft_half(24, 2)};
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  const Lattice& lattice = mesh.lattice;
  const auto cost = [&](std::size_t z) {
    const bool top = lattice.element_index(mesh.element[z])[2] + 1 == lattice.elements[2];
    return brick_cost.of(strength_of(mesh, z), top);
  };
  EXPECT_LT(worst_fraction(mesh, cost), uneven);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_fraction(mesh, [](std::size_t) { return 1; }), uneven);
  }
}

TEST(Split, YieldingTetrahedraHaveALargerWeight) {
  GroundParameters p = embankment();
  p.x = {0, 96}, p.elements_x = 64;
  p.blocks = {soft_half(96, 4)};
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  const auto cost = [&](std::size_t z) { return tetrahedron_cost.of(strength_of(mesh, z), false); };
  EXPECT_LT(worst_fraction(mesh, cost), uneven);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_fraction(mesh, [](std::size_t) { return 1; }), uneven);
  }
}

// The most uneven case: half an embankment on a thin layer that extends beside it by twice its
// width, so that one end of the ground has the whole interface. Measured weights, not those of the
// program.
TEST(Split, TetrahedraBelowStonesHaveALittleMoreWeight) {
  constexpr double measured = 0.2, far_too_much = 2, even = 1.06;
  GroundParameters p = embankment();
  p.x = {0, 4}, p.elements_x = 4;
  p.y = {0, 96}, p.elements_y = 384;
  p.layers.erase(p.layers.begin() + 1);
  p.layers[1].elements = 1, p.embankment_layers = 1;
  p.sections = {{.x = 0, .crest = 32, .slope = 0}};
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  const auto cost_with = [&](double interface) {
    return [&, interface](std::size_t z) {
      int above = 0;  // corners
      for (std::size_t c = 0; c < 4; ++c)
        above += mesh.position(mesh.imported->corner[z][c]).z() == 0 ? 1 : 0;
      return 1 + (above == 3 ? interface : 0);
    };
  };
  EXPECT_LT(worst_fraction(mesh, cost_with(measured)), even);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_fraction(mesh, cost_with(far_too_much)), even);
  }
}

// A row of elements, the first fifth below stones.
TEST(Split, InterfaceHasALargerWeight) {
  constexpr int elements = 1000, below = elements / 5;
  std::vector<std::int32_t> corners;
  std::vector<double> cost;
  for (std::int32_t e = 0; e < elements; ++e) {
    corners.push_back(e), corners.push_back(e + 1);
    cost.push_back(brick_cost.of({}, e < below));
  }
  const auto owner = split_nodes({corners, 2, 1}, cost, corners, elements + 1, 2);
  double first = 0;
  for (std::size_t e = 0; e < elements; ++e)
    if (owner[e] == owner[0]) first += cost[e];
  const double all = std::accumulate(cost.begin(), cost.end(), 0.0);
  EXPECT_NEAR(first / all, 0.5, 0.02);
}

}  // namespace
}  // namespace trackbed::fem::split_test
