// Points within the ground have the motion of its elements, as the fields show it, and are found
// wherever they lie.
#include <gtest/gtest.h>

#include <cmath>

#include "trackbed/io/fields.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::ground_points_test {
namespace {

using par::Comm;

std::vector<Vec3> uneven_load(const Surface& top, int window) {
  std::vector<Vec3> force;
  for (const Vec3& x : top.position)
    force.emplace_back(300 * std::sin(1 + 2 * x.x()), 0,
                       -1e3 * (2 + std::sin(window + x.x() - 0.5 * x.y())));
  return force;
}

// Displacement, velocity, acceleration, stress since static equilibrium and stress in it.
constexpr std::size_t numbers = 21;

struct Known {
  std::array<double, 3> at{};
  std::array<double, numbers> values{};
  Vec3 place() const { return {at[0], at[1], at[2]}; }
};

// The centres of all elements by the fields' points, from all ranks. Shape functions there: of a
// brick 1/8 of each corner; of a tetrahedron -1/8 of each corner, 1/4 of each node in mid-edge.
std::vector<Known> centres(const Comm& comm, const Ground& ground) {
  const io::Grid grid = ground.fields();
  const bool bricks = grid.kind == io::CellKind::hexahedron;
  const std::size_t nodes = bricks ? 8 : 10;
  EXPECT_EQ(grid.cell_data[0].name, "stress_change");
  EXPECT_EQ(grid.cell_data[1].name, "stress_static");
  std::vector<Known> mine;
  for (std::size_t c = 0; c < grid.cells.size() / nodes; ++c) {
    Known one;
    for (std::size_t k = 0; k < nodes; ++k) {
      const auto point = static_cast<std::size_t>(grid.cells[nodes * c + k]);
      const double weight = bricks ? 1.0 / 8 : k < 4 ? -1.0 / 8 : 1.0 / 4;
      for (std::size_t a = 0; a < 3; ++a)
        one.at[a] += weight * grid.points[point][static_cast<int>(a)];
      for (std::size_t q = 0; q < 3; ++q)
        for (std::size_t a = 0; a < 3; ++a)
          one.values[3 * q + a] += weight * grid.point_data[q].values[3 * point + a];
    }
    for (const std::ptrdiff_t field : {0, 1}) {
      const double* s = &grid.cell_data[field].values[6 * c];  // xx yy zz xy yz zx
      const std::array<double, 6> in_order{s[0], s[1], s[2], s[3], s[5], s[4]};
      std::copy(in_order.begin(), in_order.end(), one.values.begin() + 9 + 6 * field);
    }
    mine.push_back(one);
  }
  return comm.all_gather(std::span<const Known>(mine));
}

// Relative to the largest value of each kind: rounding of sums of ten terms and of places.
constexpr double rounding = 1e-11;

void expect_states(const Comm& comm, const Ground& ground, const std::vector<Known>& known) {
  std::vector<Vec3> places;
  for (const Known& one : known) places.push_back(one.place());
  const std::vector<GroundPoint> points = ground.locate(places);
  const std::vector<GroundPointState> states = ground.states_at(points);
  std::array<double, 5> largest{};
  const auto kind = [](std::size_t k) { return k < 9 ? k / 3 : 3 + (k - 9) / 6; };
  for (const Known& one : known)
    for (std::size_t k = 0; k < numbers; ++k)
      largest[kind(k)] = std::max(largest[kind(k)], std::abs(one.values[k]));
  for (const double most : largest) EXPECT_GT(most, 0);
  for (std::size_t p = 0; p < known.size(); ++p) {
    ASSERT_GE(points[p].element, 0) << known[p].place().transpose();
    const GroundPointState& state = states[p];
    for (std::size_t k = 0; k < numbers; ++k) {
      const int a = static_cast<int>(k % 3);
      const double value = k < 3    ? state.displacement[a]
                           : k < 6  ? state.velocity[a]
                           : k < 9  ? state.acceleration[a]
                           : k < 15 ? state.stress[k - 9]
                                    : state.stress_static[k - 15];
      ASSERT_NEAR(value, known[p].values[k], rounding * largest[kind(k)])
          << "number " << k << " at " << known[p].place().transpose() << " of " << comm.size();
    }
  }
}

void shake(Ground& ground) {
  ground.settle(uneven_load(ground.top(), 0));
  for (int w = 1; w < 4; ++w) ground.advance(ground.stable_step(), uneven_load(ground.top(), w));
}

class Points : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Points, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Of plane strain in a plane.
GroundParameters bricks() {
  GroundParameters p = box({3, 1, 1}, {12, 3, 5}, {80e6, 0.3, 1900});
  p.plane = PlaneState::strain;
  return p;
}

void expect_motion_of_centres(const GroundParameters& p, Dimension dimension) {
  const Comm world = Comm::world();
  Ground ground(world, p, dimension, 1.0);
  shake(ground);
  expect_states(world, ground, centres(world, ground));
}

TEST_P(Points, MoveAsTheCentresOfBricks) {
  GroundParameters p = bricks();
  p.ratio_x = 0.9, p.fine_x = 3;
  expect_motion_of_centres(p, GetParam());
}

// Both ends of a periodic ground have the same nodes.
TEST_P(Points, MoveAsTheCentresOfPeriodicBricks) {
  GroundParameters p = bricks();
  p.side_x_low = p.side_x_high = Sides::periodic;
  expect_motion_of_centres(p, GetParam());
}

// Between nodes along a straight line the motion of a brick is linear.
TEST_P(Points, MoveLinearlyAlongEdges) {
  Ground ground(Comm::world(), bricks(), GetParam(), 1.0);
  shake(ground);
  std::vector<Vec3> steps{{0.25, 0, 0}, {0, 0, 0.2}};
  if (GetParam() == Dimension::space) steps.emplace_back(0, 1.0 / 3, 0);
  for (const Vec3& step : steps) {
    const Vec3 from(1.5, GetParam() == Dimension::plane ? 0.0 : 1.0 / 3, -0.6);
    const auto points =
        ground.locate(std::vector<Vec3>{from, Vec3(from + 0.3 * step), Vec3(from + step)});
    const auto states = ground.states_at(points);
    const Vec3 expected = 0.7 * states[0].velocity + 0.3 * states[2].velocity;
    EXPECT_GT((states[0].velocity - states[2].velocity).norm(), 0.01 * expected.norm());
    EXPECT_LT((states[1].velocity - expected).norm(), rounding * expected.norm());
  }
}

TEST(PointsOfTetrahedra, MoveAsTheirCentres) {
  expect_motion_of_centres(embankment(), Dimension::space);
}

// At each node the motion is that of the node, whichever element contains it.
TEST(PointsOfTetrahedra, MoveAsTheirNodes) {
  const Comm world = Comm::world();
  Ground ground(world, embankment(), Dimension::space, 1.0);
  shake(ground);
  const io::Grid grid = ground.fields();
  std::vector<Known> mine;
  for (std::size_t n = 0; n < grid.points.size(); n += 3) {
    Known one;
    for (std::size_t a = 0; a < 3; ++a) {
      one.at[a] = grid.points[n][static_cast<int>(a)];
      for (std::size_t q = 0; q < 3; ++q)
        one.values[3 * q + a] = grid.point_data[q].values[3 * n + a];
    }
    mine.push_back(one);
  }
  const std::vector<Known> known = world.all_gather(std::span<const Known>(mine));
  std::vector<Vec3> places;
  for (const Known& one : known) places.push_back(one.place());
  const auto states = ground.states_at(ground.locate(places));
  double off = 0, most = 0;
  for (std::size_t k = 0; k < known.size(); ++k)
    for (std::size_t a = 0; a < 3; ++a) {
      off =
          std::max(off, std::abs(states[k].velocity[static_cast<int>(a)] - known[k].values[3 + a]));
      most = std::max(most, std::abs(known[k].values[3 + a]));
    }
  EXPECT_GT(most, 0);
  EXPECT_LT(off, rounding * most);
}

TEST_P(Points, OutsideAreInNoElement) {
  const Comm world = Comm::world();
  Ground ground(world, box({3, 1, 1}, {12, 3, 5}, {80e6, 0.3, 1900}), GetParam(), 1.0);
  const bool plane = GetParam() == Dimension::plane;
  const auto points = ground.locate(std::vector<Vec3>{
      {1, 0.5, 0.01}, {-0.01, 0.5, -0.5}, {1, 0.5, -1.01}, {1, 1.01, -0.5}, {3, 1, 0}, {0, 0, -1}});
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(points[k].element, -1) << k;
  EXPECT_EQ(points[3].element == -1, !plane);
  EXPECT_GE(points[4].element, 0);
  EXPECT_GE(points[5].element, 0);
}

// Above the slope of the sides there is no element, though their box reaches there.
TEST(PointsOfTetrahedra, OutsideAreInNoElement) {
  Ground ground(Comm::world(), embankment(), Dimension::space, 1.0);
  const auto points =
      ground.locate(std::vector<Vec3>{{3, 5, -0.5}, {3, 3.5, -0.5}, {3, 0, 0}, {3, 10, -2}});
  EXPECT_EQ(points[0].element, -1);
  for (std::size_t k = 1; k < 4; ++k) EXPECT_GE(points[k].element, 0) << k;
}

}  // namespace
}  // namespace trackbed::fem::ground_points_test
