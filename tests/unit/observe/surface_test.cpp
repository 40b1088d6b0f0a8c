// The height of a bed seen from above, for balls with known tops.
#include <gtest/gtest.h>

#include <cmath>

#include "support/scene.hpp"
#include "support/stones.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::surface_test {
namespace {

constexpr double r = 0.05, cell = 0.1;  // m

// Balls over the middles of some cells of a floor of 1.0 by 0.6 m, periodic in x.
std::vector<double> tops(const par::Comm& comm, const std::vector<Vec3>& balls) {
  dem::Domain domain;
  domain.periodic = {true, false, false};
  domain.low = {0, -0.3, -1}, domain.high = {1, 0.3, 3};
  dem::ContactLaw law;
  dem::Particles particles(comm, test::one_material(law, 2500), {.gravity = 0}, domain);
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> all;
  for (std::size_t i = 0; i < balls.size(); ++i)
    all.push_back({.id = static_cast<Id>(i), .scale = r, .position = balls[i]});
  if (!comm.root()) all.clear();
  particles.add(all);
  return observe::surface_of(comm, particles, cell);
}

const double* row(const std::vector<double>& rows, std::size_t i, std::size_t j) {
  return &rows.at(3 * (j * 10 + i));
}

TEST(Surface, IsTheHighestPointInEachCell) {
  const par::Comm world = par::Comm::world();
  const auto rows =
      tops(world, {{0.25, -0.05, 0.5}, {0.25, -0.05, 0.2}, {0.75, 0.25, 0.3}, {1.15, 0.05, 0.4}});
  ASSERT_EQ(rows.size(), 3u * 10 * 6);
  EXPECT_NEAR(row(rows, 2, 2)[0], 0.25, 1e-12);
  EXPECT_NEAR(row(rows, 2, 2)[1], -0.05, 1e-12);
  EXPECT_NEAR(row(rows, 2, 2)[2], 0.5 + r, 1e-12);
  EXPECT_NEAR(row(rows, 7, 5)[2], 0.3 + r, 1e-12);
  EXPECT_NEAR(row(rows, 1, 3)[2], 0.4 + r, 1e-12);  // periodic image at x = 0.15
  EXPECT_TRUE(std::isnan(row(rows, 5, 0)[2]));
  const auto alone =
      tops(par::Comm::self(),
           {{0.25, -0.05, 0.5}, {0.25, -0.05, 0.2}, {0.75, 0.25, 0.3}, {1.15, 0.05, 0.4}});
  for (std::size_t k = 0; k < rows.size(); ++k)
    EXPECT_TRUE(rows[k] == alone[k] || (std::isnan(rows[k]) && std::isnan(alone[k])));
}

// A ball over the border of two cells is in both, and lower by less than the spacing of its points
// where it is cut off-centre.
TEST(Surface, IncludesStonesThatReachIntoANeighbour) {
  const auto rows = tops(par::Comm::world(), {{0.3, -0.05, 0.5}});
  EXPECT_NEAR(row(rows, 2, 2)[2], 0.5 + r, r / 4);  // points lie r/4 apart
  EXPECT_NEAR(row(rows, 3, 2)[2], 0.5 + r, r / 4);
  EXPECT_TRUE(std::isnan(row(rows, 4, 2)[2]));
}

}  // namespace
}  // namespace trackbed::surface_test
