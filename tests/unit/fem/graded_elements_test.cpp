// Graded elements: positions of their borders, and equal results with elements of different sizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/mesh/lattice.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::graded_elements_test {
namespace {

using par::Comm;

std::vector<double> widths(const std::vector<double>& edges) {
  std::vector<double> all;
  for (std::size_t i = 1; i < edges.size(); ++i) all.push_back(edges[i] - edges[i - 1]);
  return all;
}

TEST(Grading, ElementsGrowAwayFromTheFinestPlace) {
  GroundParameters p;
  p.x = {-10, 20};
  p.elements_x = 40;
  p.ratio_x = 1.1;
  for (const double fine : {-10.0, 0.0, 3.7, 20.0}) {
    p.fine_x = fine;
    const std::vector<double> edges = p.edges(0);
    ASSERT_EQ(edges.size(), 41);
    EXPECT_EQ(edges.front(), -10);
    EXPECT_EQ(edges.back(), 20);
    const auto at = std::find_if(edges.begin(), edges.end(),
                                 [&](double edge) { return std::abs(edge - fine) < 1e-12; });
    ASSERT_NE(at, edges.end());
    const auto middle = static_cast<std::size_t>(at - edges.begin());
    const std::vector<double> w = widths(edges);
    for (std::size_t i = 0; i + 1 < w.size(); ++i) {
      if (i + 1 == middle)
        EXPECT_LT(std::abs(std::log(w[i + 1] / w[i])), std::log(1.1));
      else
        EXPECT_NEAR(w[i + 1] / w[i], i + 1 > middle ? 1.1 : 1 / 1.1, 1e-9);
    }
  }
}

// 1 mm from an end there is no space for an element: the grading is as if finest at that end.
TEST(Grading, NoSliverIsCutOffAtAnEnd) {
  GroundParameters p;
  p.x = {0, 30};
  for (const std::int64_t elements : {2, 3, 40})
    for (const double ratio : {1.02, 1.1, 1.2})
      for (const bool high : {false, true}) {
        p.elements_x = elements, p.ratio_x = ratio;
        p.fine_x = high ? 30 : 0;
        const std::vector<double> at_end = p.edges(0);
        p.fine_x = high ? 30 - 1e-3 : 1e-3;
        EXPECT_EQ(p.edges(0), at_end);
        for (double fine = 0.01; fine < 30; fine += 0.01) {
          p.fine_x = fine;
          const std::vector<double> w = widths(p.edges(0));
          for (std::size_t i = 0; i + 1 < w.size(); ++i)
            EXPECT_LE(std::abs(std::log(w[i + 1] / w[i])), std::log(1 + ratio) + 1e-9) << fine;
        }
      }
}

TEST(Grading, LayersEndAtElementBorders) {
  GroundParameters p = column(7);
  p.layers = {{"thin", 0.1, {}}, {"deep", 6.0, {}}};
  p.layers[0].elements = 2, p.layers[1].elements = 3;
  const std::vector<double> edges = p.edges(2);
  const std::vector<double> expected = {-6.1, -4.1, -2.1, -0.1, -0.05, 0};
  ASSERT_EQ(edges.size(), expected.size());
  for (std::size_t i = 0; i < edges.size(); ++i) EXPECT_NEAR(edges[i], expected[i], 1e-12);
  const Lattice lattice = make_lattice(p, Dimension::space, 1);
  const Solids solids(p, lattice);
  EXPECT_EQ(solids.solid.size(), 2);  // one size each
  for (Id element = 0; element < lattice.element_count(); ++element) {
    const int solid = solids.of(p, lattice, element);
    EXPECT_EQ(solids.name[static_cast<std::size_t>(solid)],
              lattice.centre(element).z() > -0.1 ? "layer thin" : "layer deep");
  }
}

TEST(Solids, WithoutANameTheyHaveTheirNumber) {
  GroundParameters p = box({1, 1, 1}, {2, 2, 2}, {});
  p.layers = {{"named", 0.5, {}}, {"", 0.5, {50e6, 0.3, 2000}}};
  p.blocks = {{"", true, {0, 0, 0.5, 0, 0.5, -1, 0, -1}, {}}};
  const Solids solids(p, make_lattice(p, Dimension::space, 1));
  EXPECT_EQ(solids.name, (std::vector<std::string>{"layer named", "layer 1", "block 0"}));
}

// Soft over stiff, elements graded along all axes.
GroundParameters graded() {
  GroundParameters p = box({3, 2, 1}, {9, 6, 1}, {});
  p.layers = {{"soft", 2, {50e6, 0.3, 2000}}, {"stiff", 8, {200e6, 0.3, 2000}}};
  p.layers[0].elements = 8, p.layers[1].elements = 12;
  p.ratio_x = 1.3, p.fine_x = 1;
  p.ratio_y = 1.2;
  p.base = Base::fixed;
  p.plane = PlaneState::strain;
  return p;
}

class Graded : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Graded, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Between rollers the stress at the centre of each element is the weight above it plus the
// pressure, for any element size.
TEST_P(Graded, StressFollowsFromWeightAndPressure) {
  GroundParameters p = graded();
  p.tolerance = 1e-12;
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  ground.settle(pressure(ground, 50e3));
  const io::Grid grid = ground.fields();
  double worst = 0;  // Pa
  for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
    double z = 0;
    for (std::size_t k = 0; k < 8; ++k)
      z += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])].z() / 8;
    const double exact = -50e3 + 2000 * gravity * z;
    worst = std::max({worst, std::abs(grid.cell_data[1].values[6 * c + 2] - exact),
                      std::abs(grid.cell_data[1].values[6 * c] - exact * 0.3 / 0.7)});
    EXPECT_EQ(grid.cell_data[2].values[c], z > -2 ? 0 : 1);  // solids of the deck
  }
  // The solver's tolerance times the condition of the matrix.
  EXPECT_LT(Comm::world().max(worst), 1e-6 * 250e3);
}

// Reference case "Column" on a fixed base, elements of three heights: period 218.043 ms, largest
// downward displacement of the top 0.297143 mm.
TEST_P(Graded, ColumnHasItsPeriodAndAmplitude) {
  const Comm comm = Comm::world();
  GroundParameters p = column(1);
  p.layers = {
      {"a", 2, {50e6, 0.3, 2000}}, {"b", 3, {50e6, 0.3, 2000}}, {"c", 5, {50e6, 0.3, 2000}}};
  p.layers[0].elements = 40, p.layers[1].elements = 30, p.layers[2].elements = 40;
  Ground ground(comm, p, GetParam(), 1.0);
  const auto load = pressure(ground, 1e3);
  const double dt = ground.stable_step();
  double most = 0, when = 0;
  for (double t = dt; t < 0.15; t += dt) {
    ground.advance(dt, load);
    double down = 0;
    for (const auto n : ground.own_top())
      down = std::max(down, -ground.top_state(n).displacement.z());
    if (comm.max(down) > most) most = comm.max(down), when = t;
  }
  // Fronts are smeared over a few elements of 0.1 m: 2 % of the path of 20 m, with oscillations.
  EXPECT_NEAR(when, 0.5 * 0.218043, 0.02 * 0.109);
  EXPECT_NEAR(most, 0.297143e-3, 0.02 * 0.297143e-3);
}

TEST_P(Graded, ExplicitRunIsBitwiseIdenticalOnAnyRankCount) {
  Ground alone(Comm::self(), graded(), GetParam(), 1.0);
  Ground spread(Comm::world(), graded(), GetParam(), 1.0);
  for (Ground* ground : {&alone, &spread}) {
    std::vector<Vec3> load = pressure(*ground, 0);
    load[7] = {1e3, 0, -5e3};
    for (int w = 0; w < 30; ++w) ground->advance(3 * ground->stable_step(), load);
  }
  for (const std::int32_t own : spread.own_top()) {  // a rank has the values of its own nodes
    const auto n = static_cast<std::size_t>(own);
    EXPECT_EQ(alone.top().position[n], spread.top().position[n]);
  }
  EXPECT_NE(alone.top().position[7].z(), 0);
}

}  // namespace
}  // namespace trackbed::fem::graded_elements_test
