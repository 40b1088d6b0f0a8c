// A rectangle on a surface: weights sum to one and have the centre of its pressure, whatever faces
// it cuts; a uniform pressure gives nodes of hexahedra their tributary area, a linear one the
// integrals of their hat functions; means are bitwise identical on any number of ranks.
#include "trackbed/couple/footprints.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace trackbed::couple::footprints_test {
namespace {

constexpr double rounding = 1e-13;
constexpr int cells = 8;  // of 0.3 m along x; of 0.25 m along y

// Rectangular faces, as on a ground of hexahedra.
Surface plate() {
  Surface surface;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) surface.position.emplace_back(0.3 * i, 0.25 * j, 0.0);
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = i + (cells + 1) * j, d = a + cells + 1;
      surface.triangles.push_back({a, a + 1, d + 1});
      surface.triangles.push_back({a, d + 1, d});
    }
  return surface;
}

// Nodes are assigned to ranks in turn.
std::vector<std::int32_t> own_of(const par::Comm& comm, const Surface& surface) {
  std::vector<std::int32_t> own;
  for (int n = comm.rank(); n < static_cast<int>(surface.nodes()); n += comm.size())
    own.push_back(n);
  return own;
}

const std::vector<Rectangle> rectangles = {{{0.31, 0.88}, {0.1, 1.43}},  // across many
                                           {{0.35, 0.4}, {0.3, 0.31}},   // in one element
                                           {{0.6, 1.2}, {0.5, 1.0}},     // along borders
                                           {{0.0, 2.4}, {0.0, 2.0}}};    // all of it

void expect_force_and_moment(const Surface& surface) {
  const Footprints prints(par::Comm::world(), surface, {}, rectangles);
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    Vec3 centre = Vec3::Zero();
    double sum = 0;
    for (const auto& [node, weight] : prints.weights(i)) {
      EXPECT_GT(weight, -rounding);
      centre += weight * surface.position[static_cast<std::size_t>(node)];
      sum += weight;
    }
    EXPECT_NEAR(sum, 1, rounding);
    EXPECT_NEAR(centre.x(), (rectangles[i].x[0] + rectangles[i].x[1]) / 2, rounding);
    EXPECT_NEAR(centre.y(), (rectangles[i].y[0] + rectangles[i].y[1]) / 2, rounding);
  }
  std::vector<Vec3> load(surface.nodes(), Vec3::Zero());
  prints.add_forces(std::vector<double>{1, 2, 3, 4}, load);
  double all = 0;
  for (const Vec3& force : load) all += force.z();
  EXPECT_NEAR(all, -10, 10 * rounding);
}

TEST(Footprints, ConserveForceAndMoment) { expect_force_and_moment(plate()); }

// Triangles that form no rectangles: pairs with different first nodes, or a deformed ground.
TEST(Footprints, ConserveThemOnTriangles) {
  Surface turned = plate(), moved = plate();
  for (std::size_t t = 0; t < turned.triangles.size(); t += 2)
    std::rotate(turned.triangles[t].begin(), turned.triangles[t].begin() + 1,
                turned.triangles[t].end());
  for (int j = 1; j < cells; ++j)
    for (int i = 1; i < cells; ++i)
      moved.position[static_cast<std::size_t>(i + (cells + 1) * j)] +=
          1e-3 * Vec3(std::sin(i), std::cos(j), 1);
  expect_force_and_moment(turned);
  expect_force_and_moment(moved);
}

// Per area: a quarter of each element around a node.
TEST(Footprints, AUniformPressureIsDistributedByTributaryArea) {
  const Surface surface = plate();
  const Footprints prints(par::Comm::world(), surface, {}, rectangles);
  for (const std::size_t i : {2, 3}) {
    const Rectangle& r = rectangles[i];
    const double area = (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]);
    for (const auto& [node, weight] : prints.weights(i)) {
      const Vec3& at = surface.position[static_cast<std::size_t>(node)];
      const auto side = [&](double x, const std::array<double, 2>& range, double element) {
        return element * (std::min(x - range[0], range[1] - x) < rounding ? 0.5 : 1.0);
      };
      const double tributary = side(at.x(), r.x, 0.3) * side(at.y(), r.y, 0.25);
      EXPECT_NEAR(weight * area, tributary, rounding) << node;
    }
  }
}

// A pressure of both signs, with tension at one end.
std::vector<Rectangle> tilted(double tilt) {
  std::vector<Rectangle> all = rectangles;
  for (Rectangle& r : all) r.tilt = tilt / (r.y[1] - r.y[0]);
  return all;
}

void expect_force_where_it_acts(const Surface& surface) {
  for (const double tilt : {3.0, std::sqrt(12.0), -std::sqrt(12.0)}) {
    const std::vector<Rectangle> all = tilted(tilt);
    const Footprints prints(par::Comm::world(), surface, {}, all);
    for (std::size_t i = 0; i < all.size(); ++i) {
      Vec3 centre = Vec3::Zero();
      double sum = 0;
      for (const auto& [node, weight] : prints.weights(i)) {
        centre += weight * surface.position[static_cast<std::size_t>(node)];
        sum += weight;
      }
      const double length = all[i].y[1] - all[i].y[0];
      EXPECT_NEAR(sum, 1, rounding);
      EXPECT_NEAR(centre.x(), (all[i].x[0] + all[i].x[1]) / 2, rounding);
      EXPECT_NEAR(centre.y(), all[i].middle_y() + tilt * length / 12, rounding);
    }
  }
}

// The resultant of a linear pressure is beside the middle; on rectangles and on triangles.
TEST(Footprints, LinearPressureConservesForceAndMoment) {
  Surface turned = plate();
  for (std::size_t t = 0; t < turned.triangles.size(); t += 2)
    std::rotate(turned.triangles[t].begin(), turned.triangles[t].begin() + 1,
                turned.triangles[t].end());
  expect_force_where_it_acts(plate());
  expect_force_where_it_acts(turned);
}

// For elements of width b and a pressure p(y), an inner node gets b p there, one at the border y0
// of the rectangle b/2 p(y0) plus b^2/6 times the inward slope.
TEST(Footprints, LinearPressureGivesIntegralsOfHatFunctions) {
  const Surface surface = plate();
  const std::vector<Rectangle> all = tilted(std::sqrt(12.0));
  const Footprints prints(par::Comm::world(), surface, {}, all);
  constexpr double element = 0.25;
  for (const std::size_t i : {2, 3}) {
    const Rectangle& r = all[i];
    std::map<double, double> at_y;
    for (const auto& [node, weight] : prints.weights(i))
      at_y[surface.position[static_cast<std::size_t>(node)].y()] += weight;
    for (const auto& [y, weight] : at_y) {
      const double pressure = 1 + r.tilt * (y - r.middle_y());
      const bool low = y - r.y[0] < rounding, high = r.y[1] - y < rounding;
      double expected = element * pressure;
      if (low || high) expected = expected / 2 + (low ? 1 : -1) * element * element / 6 * r.tilt;
      EXPECT_NEAR(weight * (r.y[1] - r.y[0]), expected, rounding) << y;
    }
  }
}

// Both springs of a sleeper together give the uniform pressure, to the rounding of their sum.
TEST(Footprints, OppositeTiltsAddUpToAUniformPressure) {
  const Surface surface = plate();
  const Footprints even(par::Comm::world(), surface, {}, rectangles);
  const Footprints left(par::Comm::world(), surface, {}, tilted(3)),
      right(par::Comm::world(), surface, {}, tilted(-3));
  for (std::size_t i = 0; i < rectangles.size(); ++i)
    for (std::size_t k = 0; k < even.weights(i).size(); ++k)
      EXPECT_NEAR(left.weights(i)[k].weight + right.weights(i)[k].weight,
                  2 * even.weights(i)[k].weight, 1e-15);
}

// The part beyond the border of the surface is lost: such decks are refused.
TEST(Footprints, BeyondTheBorderWeightsSumToLess) {
  const Footprints prints(par::Comm::world(), plate(), {}, {{{2.3, 2.6}, {0.5, 1.0}}});
  double sum = 0;
  for (const auto& of : prints.weights(0)) sum += of.weight;
  EXPECT_NEAR(sum, 1.0 / 3, rounding);
}

TEST(Footprints, MeansOfAPlaneAreItsHeightAtTheCentre) {
  const par::Comm comm = par::Comm::world();
  const Surface surface = plate();
  const std::vector<std::int32_t> own = own_of(comm, surface);
  const Footprints prints(comm, surface, own, rectangles);
  const Footprints alone(par::Comm::self(), surface, own_of(par::Comm::self(), surface),
                         rectangles);
  const auto height = [&](std::int32_t node) {
    const Vec3& x = surface.position[static_cast<std::size_t>(node)];
    return 1e-3 * (1 + 2 * x.x() - 0.7 * x.y());
  };
  std::vector<Footprints::Values> mine{{{}, 10}, {{}, 1e3}}, all = mine;
  for (const std::int32_t node : own) {
    mine[0].own.push_back(height(node));
    mine[1].own.push_back(-height(node));
  }
  for (std::size_t n = 0; n < surface.nodes(); ++n) {
    all[0].own.push_back(height(static_cast<std::int32_t>(n)));
    all[1].own.push_back(-height(static_cast<std::int32_t>(n)));
  }
  const auto means = prints.means(mine);
  EXPECT_EQ(means, alone.means(all));
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    const double x = (rectangles[i].x[0] + rectangles[i].x[1]) / 2;
    const double y = (rectangles[i].y[0] + rectangles[i].y[1]) / 2;
    EXPECT_NEAR(means[0][i], 1e-3 * (1 + 2 * x - 0.7 * y), 1e-15);
    EXPECT_NEAR(means[1][i], -means[0][i], 2e-15);
  }
}

// A distant train moves the ground by 1e-12 m: its work must also balance.
TEST(Footprints, MeansResolveValuesFarBelowTheLargest) {
  const par::Comm comm = par::Comm::world();
  const Surface surface = plate();
  const std::vector<std::int32_t> own = own_of(comm, surface);
  const Footprints prints(comm, surface, own, rectangles);
  Footprints::Values small{{}, 1e3};
  for (const std::int32_t node : own)
    small.own.push_back(1e-12 * surface.position[static_cast<std::size_t>(node)].x());
  const auto means = prints.means(std::vector{small});
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    const double centre = (rectangles[i].x[0] + rectangles[i].x[1]) / 2;
    EXPECT_NEAR(means[0][i], 1e-12 * centre, 1e-22);
  }
}

}  // namespace
}  // namespace trackbed::couple::footprints_test
