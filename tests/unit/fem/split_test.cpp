// Shares of ranks follow what elements cost: those that may yield, those below the stones.
#include "fem/split.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "fem/mesh.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem {
namespace {

// METIS allows 3 % for itself; a cut lies between elements, and nodes on it go to the lower rank.
constexpr double uneven = 1.12;

// Of what this rank writes out, which is its own but for borders: largest share over the mean.
// Collective.
double worst_share(const Mesh& mesh, const std::function<double(std::size_t zone)>& cost) {
  double mine = 0;
  for (std::size_t z = 0; z < mesh.zone.size(); ++z)
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

TEST(Split, ZonesThatMayYieldWeighMore) {
  GroundParameters p = box({24, 2, 2}, {96, 8, 8}, {80e6, 0.3, 1900});
  p.blocks = {soft_half(24, 2)};
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  const Lattice& lattice = mesh.lattice;
  const auto cost = [&](std::size_t z) {
    const bool top = lattice.zone_index(mesh.zone[z])[2] + 1 == lattice.zones[2];
    return zone_cost.of(strength_of(mesh, z), top);
  };
  EXPECT_LT(worst_share(mesh, cost), uneven);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_share(mesh, [](std::size_t) { return 1; }), uneven);
  }
}

TEST(Split, TetrahedraThatMayYieldWeighMore) {
  GroundParameters p = embankment();
  p.x = {0, 96}, p.zones_x = 64;
  p.blocks = {soft_half(96, 4)};
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  const auto cost = [&](std::size_t z) { return tetrahedron_cost.of(strength_of(mesh, z), false); };
  EXPECT_LT(worst_share(mesh, cost), uneven);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_share(mesh, [](std::size_t) { return 1; }), uneven);
  }
}

// By far the most have none: half an embankment on a thin layer that goes on beside it for twice
// its width, so that one end of the ground has all of the interface. Weights as measured, not as
// the program has them.
TEST(Split, TetrahedraBelowStonesWeighLittleMore) {
  constexpr double measured = 0.2, far_too_much = 2, even = 1.06;
  GroundParameters p = embankment();
  p.x = {0, 4}, p.zones_x = 4;
  p.y = {0, 96}, p.zones_y = 384;
  p.layers.erase(p.layers.begin() + 1);
  p.layers[1].zones = 1, p.embankment_layers = 1;
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
  EXPECT_LT(worst_share(mesh, cost_with(measured)), even);
  if (mesh.comm.size() > 1) {
    EXPECT_GT(worst_share(mesh, cost_with(far_too_much)), even);
  }
}

// A row of elements of which the first fifth lies below stones.
TEST(Split, InterfaceWeighsMore) {
  constexpr int elements = 1000, below = elements / 5;
  std::vector<std::int32_t> corners;
  std::vector<double> cost;
  for (std::int32_t e = 0; e < elements; ++e) {
    corners.push_back(e), corners.push_back(e + 1);
    cost.push_back(zone_cost.of({}, e < below));
  }
  const auto owner = split_nodes({corners, 2, 1}, cost, corners, elements + 1, 2);
  double first = 0;
  for (std::size_t e = 0; e < elements; ++e)
    if (owner[e] == owner[0]) first += cost[e];
  const double all = std::accumulate(cost.begin(), cost.end(), 0.0);
  EXPECT_NEAR(first / all, 0.5, 0.02);
}

}  // namespace
}  // namespace trackbed::fem
