// Fields of the ground: principal stresses of a known state, extremes over time and through a
// checkpoint.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "fem/material/mohr_coulomb.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::ground_fields_test {
namespace {

using par::Comm;

const io::FieldData& field(const io::Grid& grid, const std::string& begin) {
  for (const auto& data : grid.cell_data)
    if (data.name.starts_with(begin)) return data;
  throw std::runtime_error("no field " + begin);
}

class Fields : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Fields, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Uniform pressure q on a column without lateral motion: s3 = -q - weight, s1 = s2 = nu/(1-nu) s3.
TEST_P(Fields, PrincipalStressesOfAColumn) {
  GroundParameters p = column(20);
  p.sides = Sides::viscous;
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  ground.settle(pressure(ground, 5e3));
  const io::Grid grid = ground.fields();
  const auto& principals = field(grid, "principal_stress");
  const auto& shear = field(grid, "largest_shear_stress");
  const double k0 = 0.3 / 0.7;
  for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
    double z = 0;
    for (std::size_t k = 0; k < 8; ++k)
      z += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])].z() / 8;
    const double vertical = -5e3 + 2000 * gravity * z;
    EXPECT_NEAR(principals.values[3 * c], k0 * vertical, 2);  // tolerance of the solver, 1e-8
    EXPECT_NEAR(principals.values[3 * c + 1], k0 * vertical, 2);
    EXPECT_NEAR(principals.values[3 * c + 2], vertical, 2);
    EXPECT_NEAR(shear.values[c], -0.5 * (1 - k0) * vertical, 2);
  }
  EXPECT_THROW(field(grid, "extreme"), std::runtime_error);
  EXPECT_THROW(field(grid, "plastic_strain"), std::runtime_error);
}

// Values by element for any distribution to ranks: by the position of its first point.
using ByPlace = std::map<std::array<std::int64_t, 3>, std::vector<double>>;

ByPlace by_place(const io::Grid& grid, const std::vector<std::string>& names) {
  ByPlace found;
  for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
    const Vec3& at = grid.points[static_cast<std::size_t>(grid.cells[8 * c])];
    auto& row =
        found[{std::llround(1e3 * at.x()), std::llround(1e3 * at.y()), std::llround(1e3 * at.z())}];
    for (const std::string& name : names) {
      const auto& data = field(grid, name);
      for (std::size_t k = 0; k < data.columns; ++k)
        row.push_back(data.values[c * data.columns + k]);
    }
  }
  return found;
}

GroundParameters shaken() {
  GroundParameters p = box({3, 1, 1}, {12, 3, 5}, {80e6, 0.3, 1900});
  p.plane = PlaneState::strain;
  p.sides = Sides::viscous;
  return p;
}

std::vector<Vec3> uneven_load(const Surface& top, int window) {
  std::vector<Vec3> force(top.nodes());
  for (std::size_t n = 0; n < force.size(); ++n)
    force[n] = {300 * std::sin(0.3 * static_cast<double>(n) + window), 0,
                -1e3 * (1 + std::sin(0.9 * window + 0.2 * static_cast<double>(n)))};
  return force;
}

// At every point, including ghosts: each integrator obtains from its accelerations in one step
//   v_1 = v_0 + h/2 (a_0 + a_1)
// under a constant load: explicit steps begin with the load of their window.
TEST_P(Fields, AccelerationAgreesWithTheVelocity) {
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    GroundParameters p = shaken();
    p.integrator = integrator;
    Ground ground(Comm::world(), p, GetParam(), 1.0);
    const double h = integrator == Integrator::explicit_ ? ground.stable_step() : 1e-3;
    ground.settle(uneven_load(ground.top(), 0));
    ground.advance(h, uneven_load(ground.top(), 1));
    const auto before = ground.fields().point_data;
    ground.advance(h, uneven_load(ground.top(), 1));
    const auto after = ground.fields().point_data;
    ASSERT_EQ(after[2].name, "acceleration");
    double off = 0, most = 0;
    for (std::size_t k = 0; k < after[1].values.size(); ++k) {
      const double kick = h / 2 * (before[2].values[k] + after[2].values[k]);
      off = std::max(off, std::abs(after[1].values[k] - before[1].values[k] - kick));
      most = std::max(most, std::abs(kick));
    }
    EXPECT_GT(most, 1e-6);
    EXPECT_LT(off, 1e-10 * most);  // rounding of the velocity
  }
}

// The extremes are the largest and least values of all instants that were taken; a new begin resets
// them.
TEST_P(Fields, ExtremesAreThoseOfTheInstants) {
  const Comm world = Comm::world();
  Ground ground(world, shaken(), GetParam(), 1.0);
  ground.settle(uneven_load(ground.top(), 0));
  const auto columns = [&] { return ground.fields().cell_data.size(); };
  const std::size_t without = columns();
  ground.take_extremes();
  EXPECT_GT(columns(), without) << "the first instant starts the extremes";
  ground.begin_extremes();
  const double dt = 3 * ground.stable_step();
  ByPlace most;
  for (int w = 0; w < 12; ++w) {
    ground.advance(dt, uneven_load(ground.top(), w));
    if (w % 3 == 2) continue;  // not every window is taken
    ground.take_extremes();
    for (const auto& [place, row] :
         by_place(ground.fields(),
                  {"principal_stress", "largest_shear_stress", "stress_change", "stress_static"})) {
      const double vertical = row[4 + 2] + row[10 + 2];
      const std::vector<double> now = {row[0], -row[2], row[3], vertical, -vertical};
      auto& so_far = most.try_emplace(place, now).first->second;
      for (std::size_t q = 0; q < now.size(); ++q) so_far[q] = std::max(so_far[q], now[q]);
    }
  }
  const std::string path = "extremes_on_" + std::to_string(world.size()) +
                           (GetParam() == Dimension::plane ? "_plane.h5" : "_space.h5");
  {
    io::File file(world, path, io::Mode::create);
    ground.save(file, "ground");
  }
  Ground alone(Comm::self(), shaken(), GetParam(), 1.0);
  {
    const io::File file(world, path, io::Mode::read);
    alone.load(file, "ground");
  }
  const auto shown = by_place(ground.fields(), {"extreme"});
  const auto all = by_place(alone.fields(), {"extreme_largest_principal", "extreme_least_principal",
                                             "extreme_largest_shear", "extreme_largest_vertical",
                                             "extreme_least_vertical"});
  for (const auto& [place, row] : most) {
    const auto& found = all.at(place);
    for (std::size_t q = 0; q < row.size(); ++q)
      EXPECT_EQ(found[q], q == 1 || q == 4 ? -row[q] : row[q]);
    EXPECT_EQ(shown.at(place)[0], found[0]);
  }
  EXPECT_GT(world.max(static_cast<std::int64_t>(most.size())), 0);
  alone.begin_extremes();
  EXPECT_TRUE(std::isnan(by_place(alone.fields(), {"extreme"}).begin()->second[0]));
  alone.end_extremes();
  EXPECT_EQ(alone.fields().cell_data.size(), without);
}

// Trace, second and third invariant, and axes; both with one axis along y and without.
TEST(Principal, IsThatOfTheTensor) {
  double seed = 0.1;
  const auto next = [&] { return std::sin(1e4 * (seed += 0.61)) * 1e5; };
  for (int n = 0; n < 2000; ++n) {
    Vec6 s;
    for (double& part : s) part = next();
    if (n % 2 == 0) s(3) = s(4) = 0;
    const Principal found = principal(s);
    Mat3 tensor;
    tensor << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
    const Mat3 again = found.axes * found.value.asDiagonal() * found.axes.transpose();
    EXPECT_LT((again - tensor).norm(), 1e-9 * tensor.norm());
    EXPECT_LT((found.axes.transpose() * found.axes - Mat3::Identity()).norm(), 1e-12);
    EXPECT_GE(found.value(0), found.value(1));
    EXPECT_GE(found.value(1), found.value(2));
  }
}

}  // namespace
}  // namespace trackbed::fem::ground_fields_test
