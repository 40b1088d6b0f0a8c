// Solids with individual damping, and a modulus that changes along the track.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::materials_test {
namespace {

using par::Comm;

GroundParameters layered(Integrator integrator) {
  GroundParameters p = box({4, 2, 2}, {16, 4, 8}, {});
  p.layers = {{"top", 0.7, {80e6, 0.35, 1900}}, {"sub", 1.3, {200e6, 0.3, 2000}}};
  p.sides = Sides::viscous;
  p.base_stiffness = 1e8;
  p.integrator = integrator;
  p.tolerance = 1e-12;
  return p;
}

// A non-uniform pressure that rises and falls smoothly in 12.5 ms.
std::vector<double> run(const Comm& comm, Ground& ground, int windows = 25) {
  auto unit = pressure(ground, 1e3);
  for (std::size_t n = 0; n < unit.size() / 3; ++n) unit[n] *= 2;
  auto load = unit;
  for (int w = 1; w <= windows; ++w) {
    for (std::size_t n = 0; n < load.size(); ++n)
      load[n] = (1 - std::cos(2 * M_PI * w / windows)) * unit[n];
    ground.advance(12.5e-3 / windows, load);
  }
  std::vector<double> shown(3 * ground.top().nodes(), 0.0);
  for (const auto n : ground.own_top())
    for (int c = 0; c < 3; ++c)
      shown[3 * static_cast<std::size_t>(n) + static_cast<std::size_t>(c)] =
          ground.top_state(n).velocity[c];
  comm.sum(std::span<double>(shown));
  return shown;
}

std::vector<double> run(const Comm& comm, const GroundParameters& p, Dimension dimension,
                        int windows = 25) {
  Ground ground(comm, p, dimension, 1.0);
  return run(comm, ground, windows);
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0, size = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    most = std::max(most, std::abs(a[n] - b[n]));
    size = std::max(size, std::abs(a[n]));
  }
  return most / size;
}

class Materials : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Materials, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Equal damping in every solid is that of the ground, up to rounding by another order of sums.
TEST_P(Materials, DampingOfEachSolidIsThatOfTheGround) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::bossak}) {
    GroundParameters common = layered(integrator), own = common;
    const auto bare = run(comm, common, GetParam());
    common.rayleigh_mass = 30, common.rayleigh_stiffness = 5e-5;
    for (Layer& layer : own.layers)
      layer.solid.rayleigh_mass = 30, layer.solid.rayleigh_stiffness = 5e-5;
    const auto expected = run(comm, common, GetParam());
    EXPECT_LT(difference(expected, run(comm, own, GetParam())),
              integrator == Integrator::explicit_ ? 1e-11 : 1e-8);  // rounding; tolerance
    EXPECT_GT(difference(expected, bare), 0.01);
  }
}

// Between none and all; bitwise identical on any number of ranks; explicit and implicit agree.
TEST_P(Materials, OneLayerIsDamped) {
  const Comm comm = Comm::world();
  GroundParameters p = layered(Integrator::explicit_);
  p.rayleigh_stiffness = 1e-5;
  const double step = Ground(comm, p, GetParam(), 1.0).stable_step();
  p.layers[1].solid.rayleigh_mass = 30, p.layers[1].solid.rayleigh_stiffness = 2e-4;
  EXPECT_LT(Ground(comm, p, GetParam(), 1.0).stable_step(), step);
  Ground alone(Comm::self(), p, GetParam(), 1.0), spread(comm, p, GetParam(), 1.0);
  const auto a = run(Comm::self(), alone), b = run(comm, spread);
  EXPECT_EQ(a, b);
  GroundParameters all = p, implicit = p;
  all.rayleigh_mass = 30, all.rayleigh_stiffness = 2e-4;
  EXPECT_LT(spread.stable_step(), step);
  EXPECT_GT(difference(a, run(comm, all, GetParam())), 0.01);
  implicit.integrator = Integrator::newmark;
  // The explicit load lags by half a window: 1 % of the pulse.
  EXPECT_LT(difference(run(comm, p, GetParam(), 100), run(comm, implicit, GetParam(), 100)), 0.03);
}

// A smooth step of the modulus: 1/2 (1 + tanh((x - 2) / 0.5)) of the change from 80 MPa to 30 GPa.
double step_at(double x) { return 80e6 + 0.5 * (1 + std::tanh((x - 2) / 0.5)) * (30e9 - 80e6); }

std::string step_table() {
  const std::string path =
      fmt::format("young_{}_{}.csv", Comm::world().size(), Comm::world().rank());
  std::ofstream file(path);
  file << "x_m,young_Pa\n";
  for (int r = 0; r <= 20; ++r) {
    const double x = 0.875 + r * 0.125;
    file << fmt::format("{},{}\n", x, step_at(x));
  }
  return path;
}

// Equal to a ground of one block per column of elements, except for the rounding of the factors of
// the columns in the kernel; bitwise identical on any number of ranks (explicit).
TEST_P(Materials, ModulusAlongTheTrack) {
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    GroundParameters table = layered(integrator), blocks = table;
    table.layers[0].young_file = step_table();
    for (int i = 0; i < 16; ++i) {
      const double low = 0.25 * i, high = low + 0.25;
      Block block{"column", true, {low, 0, high, 0, high, -0.7, low, -0.7}, blocks.layers[0].solid};
      block.solid.young = step_at(std::clamp(low + 0.125, 0.875, 3.375));  // held beyond the table
      blocks.blocks.push_back(block);
    }
    const auto a = run(Comm::self(), table, GetParam()), b = run(Comm::self(), blocks, GetParam());
    EXPECT_LT(difference(a, b), 1e-12);  // digits of the table
    Ground spread(Comm::world(), table, GetParam(), 1.0);
    const auto c = run(Comm::world(), spread);
    EXPECT_LT(difference(a, c), integrator == Integrator::explicit_ ? 1e-300 : 1e-8);
  }
}

// Its columns are separate solids in the force kernel, but not in the fields.
TEST_P(Materials, FieldsNameTheLayerWhateverItsModulus) {
  GroundParameters p = layered(Integrator::explicit_);
  p.layers[0].young_file = step_table();
  p.blocks = {{"corner", true, {0, 0, 0.5, 0, 0.5, -0.7, 0, -0.7}, p.layers[1].solid}};
  for (const double ratio : {1.0, 1.1}) {
    p.ratio_x = ratio;
    const io::Grid grid = Ground(Comm::world(), p, GetParam(), 1.0).fields();
    ASSERT_EQ(grid.cell_data[2].name, "solid");
    for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
      Vec3 centre = Vec3::Zero();
      for (std::size_t k = 0; k < 8; ++k)
        centre += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])] / 8;
      const int layer = centre.z() > -0.7 ? 0 : 1;
      EXPECT_EQ(grid.cell_data[2].values[c], layer == 0 && centre.x() < 0.5 ? 2 : layer);
    }
  }
}

TEST(Modulus, RefusesInvalidTables) {
  const auto words = [](const std::string& rows) {
    const std::string path = fmt::format("no_young_{}.csv", Comm::world().rank());
    std::ofstream(path) << "x_m,young_Pa\n" << rows;
    GroundParameters p = layered(Integrator::explicit_);
    p.layers[0].young_file = path;
    try {
      Ground ground(Comm::self(), p, Dimension::plane, 1.0);
    } catch (const InputError& error) {
      return error.problems().front();
    }
    return std::string();
  };
  EXPECT_EQ(words("0,1e6\n1,2e6\n"), "");
  EXPECT_NE(words("0,1e6\n1,0\n").find("must be above 0"), std::string::npos);
  EXPECT_NE(words("").find("at least one row"), std::string::npos);
}

}  // namespace
}  // namespace trackbed::fem::materials_test
