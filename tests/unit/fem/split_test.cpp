// Shares of ranks follow what elements cost: those that may yield, those below the stones.
#include "fem/split.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "fem/mesh.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem {
namespace {

// METIS allows 3 % for itself; a cut lies between elements, and nodes on it go to the lower rank.
constexpr double uneven = 1.12;

constexpr Strength clay{Yield::mohr_coulomb, 20e3, 0, 0, 5e3};

// Of what this rank writes out: largest share of a rank over the mean. Collective.
double worst_share(const Mesh& mesh, const ElementCost& cost, bool weighted) {
  double mine = 0;
  for (std::size_t z = 0; z < mesh.zone.size(); ++z)
    if (mesh.writes(z))
      mine += weighted
                  ? cost.of(mesh.solids.strength[static_cast<std::size_t>(mesh.solid[z])], false)
                  : 1;
  const par::Comm& comm = mesh.comm;
  return comm.max(mine) * comm.size() / comm.sum(mine);
}

TEST(Split, ZonesThatMayYieldWeighMore) {
  GroundParameters p = box({12, 2, 2}, {48, 8, 8}, {80e6, 0.3, 1900});
  p.blocks = {{"soft", true, {0, 0, 6, 0, 6, -2, 0, -2}, {20e6, 0.3, 1900}}};
  p.blocks[0].strength = clay;
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  EXPECT_LT(worst_share(mesh, zone_cost, true), uneven);
  if (mesh.comm.size() > 1) EXPECT_GT(worst_share(mesh, zone_cost, false), uneven);
}

TEST(Split, TetrahedraThatMayYieldWeighMore) {
  GroundParameters p = embankment();
  p.x = {0, 24}, p.zones_x = 16;
  p.blocks = {{"soft", true, {0, 0, 12, 0, 12, -4, 0, -4}, {20e6, 0.3, 1900}}};
  p.blocks[0].strength = clay;
  const Mesh mesh(par::Comm::world(), p, Dimension::space, 1);
  EXPECT_LT(worst_share(mesh, tetrahedron_cost, true), uneven);
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
