// Yielding elements: the kernel against element matrices, bitwise identity on ranks and through
// checkpoints, the energy balance, and a static state that is not elastic.
#include "fem/kernel/plasticity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "trackbed/core/error.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/yielding_scene.hpp"

namespace trackbed::fem::plasticity_test {
namespace {

using par::Comm;

class Plastic : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Plastic, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

TEST_P(Plastic, PatternsAreTheMatrices) {
  const bool flat = GetParam() == Dimension::plane;
  const ElementPoints points = element_points({0.3, 0.2, 0.1}, {50e6, 0.3, 2000}, GetParam());
  const int corners = flat ? 4 : 8, parts = points.components, freedoms = flat ? 2 : 3;
  std::mt19937_64 random(3);
  const auto compare = [&](const Eigen::MatrixXd& matrix, int rows, int columns) {
    const PatternMap map(matrix, rows, columns, corners);
    EXPECT_LE(map.entries(), static_cast<std::size_t>(matrix.size() / (flat ? 4 : 8)));
    Eigen::VectorXd x(columns * corners);
    for (double& value : x) value = std::uniform_real_distribution<double>(-1, 1)(random);
    // Separate components, in lane 5.
    Lane in[48], out[48];
    for (int c = 0; c < columns; ++c)
      for (int p = 0; p < corners; ++p) {
        Lane& lane = in[c * corners + p];
        lane = Lane{};
        for (int k = 0; k < corners; ++k) lane[5] += pattern_sign(p, k) * x(columns * k + c);
      }
    map.apply(in, out);
    const Eigen::VectorXd exact = matrix * x;
    for (int c = 0; c < rows; ++c)
      for (int k = 0; k < corners; ++k) {
        double sum = 0;
        for (int p = 0; p < corners; ++p) sum += pattern_sign(p, k) * out[c * corners + p][5];
        EXPECT_NEAR(sum, exact(rows * k + c), 1e-12 * matrix.cwiseAbs().maxCoeff() * 48);
      }
  };
  compare(points.recovery, parts, freedoms);
  compare(points.relief, parts, parts);
  compare(points.recovery.transpose(), freedoms, parts);
}

// Uniform strain of a whole element, as thermal strain: no stress with free corners.
TEST_P(Plastic, UniformPlasticStrainIsFreeOfStress) {
  const bool flat = GetParam() == Dimension::plane;
  const Vec3 size(0.3, 0.2, 0.1);
  const Elastic solid{50e6, 0.3, 2000};
  const ElementPoints points = element_points(size, solid, GetParam());
  const ElementMatrices element = element_matrices(size, solid, GetParam(), PlaneState::strain);
  const int corners = flat ? 4 : 8, freedoms = flat ? 2 : 3, parts = points.components;
  Eigen::VectorXd u(freedoms * corners), e(parts * corners);
  for (int k = 0; k < corners; ++k) {
    const int z = flat ? k >> 1 : k >> 2;
    for (int c = 0; c < parts; ++c) e(parts * k + c) = 0;
    e(parts * k) = 1e-3, e(parts * k + 2) = -2e-3, e(parts * k + parts - 1) = 5e-4;
    u(freedoms * k) = 1e-3 * (k & 1) * size.x() + 5e-4 * z * size.z();
    if (!flat) u(freedoms * k + 1) = 0;
    u(freedoms * k + freedoms - 1) = -2e-3 * z * size.z();
  }
  const double scale = 50e6 * 1e-3;
  EXPECT_LT((points.recovery * u + points.relief * e).cwiseAbs().maxCoeff(), 1e-9 * scale);
  const Eigen::VectorXd force =
      element.stiffness * u - points.weighted(points.recovery).transpose() * e;
  EXPECT_LT(force.cwiseAbs().maxCoeff(), 1e-9 * scale);
}

// Compression along any axis, with half of it across: the measure is that compression. Turned about
// y in a plane, about y and z in space, so that all shear strains occur.
TEST_P(Plastic, TheMeasureOfStrainDoesNotDependOnItsAxes) {
  const bool flat = GetParam() == Dimension::plane;
  GroundParameters parameters = box({1, 1, 1}, {1, 1, 1}, {50e6, 0.3, 2000});
  parameters.layers[0].strength = {Yield::mohr_coulomb, 20e3, 30, 0, 10e3};
  const Mesh mesh(Comm::self(), parameters, GetParam(), 1.0);
  Plasticity plasticity(mesh);
  const ElementPoints points = element_points(mesh.lattice.size, {50e6, 0.3, 2000}, GetParam());
  const std::size_t count = plasticity.width() / static_cast<std::size_t>(points.components);
  constexpr double size = 3e-3;
  for (const double turn : {0.0, 0.3, 0.8, 1.5}) {
    Mat3 about = Eigen::AngleAxisd(turn, Vec3::UnitY()).toRotationMatrix();
    if (!flat) about = about * Eigen::AngleAxisd(1.1 * turn, Vec3::UnitZ());
    const Mat3 e = about * Vec3(-size, size / 2, size / 2).asDiagonal() * about.transpose();
    const double voigt[] = {e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0)};
    for (int c = 0; c < points.components; ++c)
      for (std::size_t g = 0; g < count; ++g)
        plasticity.element(0).strain[static_cast<std::size_t>(c) * count + g] =
            voigt[points.voigt(c)];
    EXPECT_NEAR(plasticity.equivalent_strain(0), size, 1e-12 * size) << turn;
  }
}

TEST_P(Plastic, IsBitwiseIdenticalOnRanksAndThroughACheckpoint) {
  const Comm world = Comm::world(), self = Comm::self();
  const std::string path = "plastic_on_" + std::to_string(world.size()) +
                           (GetParam() == Dimension::plane ? "_plane.h5" : "_space.h5");
  Ground spread(world, yielding_scene(), GetParam(), 1.0),
      alone(self, yielding_scene(), GetParam(), 1.0);
  const double dt = 2.5 * spread.stable_step();
  const auto go = [&](Ground& ground, int from, int to) {
    for (int w = from; w < to; ++w) ground.advance(dt, load_of(ground.top(), w));
  };
  spread.settle(settled(spread.top()));
  alone.settle(settled(alone.top()));
  go(spread, 0, 8);
  go(alone, 0, 15);
  {
    io::File file(world, path, io::Mode::create);
    spread.save(file, "ground");
  }
  go(spread, 8, 15);
  EXPECT_EQ(bits(world, spread), bits(self, alone));
  EXPECT_GT(alone.totals().plastic, 0.01 * alone.totals().elastic);  // much of it yields

  Ground resumed(world, yielding_scene(), GetParam(), 1.0),
      one(self, yielding_scene(), GetParam(), 1.0);
  {
    const io::File file(world, path, io::Mode::read);
    resumed.load(file, "ground");
    one.load(file, "ground");
  }
  go(resumed, 8, 15);
  go(one, 8, 15);
  EXPECT_EQ(bits(world, resumed), bits(self, alone));
  EXPECT_EQ(bits(self, one), bits(self, alone));
  // Sums over ranks have another order.
  EXPECT_NEAR(resumed.totals().plastic, alone.totals().plastic, 1e-12 * alone.totals().plastic);
}

// Layers with a strength that is not reached are bitwise identical to elastic ones.
TEST_P(Plastic, StrongLayersAreBitwiseIdenticalToElasticOnes) {
  const Comm self = Comm::self();
  GroundParameters strong = yielding_scene(), elastic = yielding_scene();
  for (Strength* s : {&strong.layers[0].strength, &strong.blocks[0].strength}) {
    s->cohesion = 1e9;
    s->tensile_strength = 1e9;
  }
  elastic.layers[0].strength.yield = elastic.blocks[0].strength.yield = Yield::none;
  Ground a(self, strong, GetParam(), 1.0), b(self, elastic, GetParam(), 1.0);
  const double dt = 2.5 * a.stable_step();
  a.settle(settled(a.top()));
  b.settle(settled(b.top()));
  for (int w = 0; w < 8; ++w) {
    a.advance(dt, load_of(a.top(), w));
    b.advance(dt, load_of(b.top(), w));
  }
  EXPECT_EQ(bits(self, a), bits(self, b));
  EXPECT_EQ(a.totals().plastic, 0);
  // Both static solvers agree to their tolerance.
  const auto one = a.fields(), other = b.fields();
  double most = 0, difference = 0;
  for (std::size_t k = 0; k < one.cell_data[1].values.size(); ++k) {
    most = std::max(most, std::abs(other.cell_data[1].values[k]));
    difference =
        std::max(difference, std::abs(one.cell_data[1].values[k] - other.cell_data[1].values[k]));
  }
  EXPECT_LT(difference, 1e-5 * most);
}

// Work of the load = kinetic + elastic + dissipated energy, without other dissipation: to the order
// of the step. With weight and a static state that has yielded.
TEST_P(Plastic, EnergyIsBalanced) {
  const Comm self = Comm::self();
  const auto error = [&](double safety) {
    GroundParameters p = yielding_scene();
    p.base = Base::fixed;
    p.sides = Sides::roller;
    p.rayleigh_stiffness = 0;
    p.safety = safety;
    Ground ground(self, p, GetParam(), 1.0);
    const auto static_load = settled(ground.top()), push = load_of(ground.top(), 5);
    ground.settle(static_load);
    double work = 0;
    const double lost = ground.totals().plastic, dt = 1e-4;
    for (int w = 0; w < 150; ++w) {
      const auto& load = w < 40 ? push : static_load;
      ground.advance(dt, load);
      for (std::size_t n = 0; n < load.size(); ++n)
        work += (load[n] - static_load[n]).dot(ground.top().motion[n]);
    }
    const GroundTotals end = ground.totals();
    EXPECT_GT(end.plastic - lost, 0.1 * work);
    return std::abs(end.kinetic + end.elastic + end.plastic - lost - work) / work;
  };
  // Order one, as the return mapping: a fifth of the step, less than half of the error, and more
  // than a 25th, which would be order two.
  const double coarse = error(0.1), fine = error(0.02);
  EXPECT_LT(coarse, 0.0135);
  EXPECT_LT(fine, 0.004);
  EXPECT_LT(fine, 0.5 * coarse);
  EXPECT_GT(fine, coarse / 25);
}

// K0 = nu/(1 - nu) is below the active pressure of Rankine: the static state yields to it. With a
// tension cut-off at zero the top has no tension.
TEST_P(Plastic, StaticStateYieldsToTheActivePressure) {
  GroundParameters p = box({1, 1, 4}, {2, 2, 32}, {50e6, 0.1, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.tolerance = 1e-10;
  p.layers[0].strength = {Yield::mohr_coulomb, 5e3, 30, 0, 0};
  Ground ground(Comm::world(), p, GetParam(), 1.0);
  ground.settle(std::vector<Vec3>(ground.top().nodes(), Vec3::Zero()));
  const io::Grid grid = ground.fields();
  const double n = 3, limit = 2 * 5e3 * std::sqrt(n), weight = 2000 * gravity;
  double most = 0;
  for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
    double z = 0;
    for (std::size_t k = 0; k < 8; ++k)
      z += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])].z() / 8;
    const double vertical = weight * z, elastic = vertical * 0.1 / 0.9;
    const double active = std::min(0.0, (limit + vertical) / n);
    most = std::max({most, std::abs(grid.cell_data[1].values[6 * c + 2] - vertical),
                     std::abs(grid.cell_data[1].values[6 * c] - std::min(elastic, active))});
  }
  // An element in which the surface is reached halfway has a mean between both: an eighth of the
  // weight of an element.
  EXPECT_LT(Comm::world().max(most), weight * 4.0 / 32 / 8);
}

TEST(Rest, RefusesAnUnstableCut) {
  GroundParameters p = box({4, 1, 4}, {8, 1, 8}, {50e6, 0.3, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.sides = Sides::free;
  // Largest height of a cut: 4 c/weight tan(45 + phi/2); 4 m need more than 5 kPa, less than 50
  // kPa.
  p.layers[0].strength = {Yield::mohr_coulomb, 50e3, 20, 0, 10e3};
  const std::vector<Vec3> none(2 * 9, Vec3::Zero());
  Ground(Comm::world(), p, Dimension::plane, 1.0).settle(none);
  p.layers[0].strength.cohesion = 5e3;
  try {
    Ground(Comm::world(), p, Dimension::plane, 1.0).settle(none);
    FAIL() << "a cut of 4 m of soft soil is stable";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("static solve of the ground did not converge"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace trackbed::fem::plasticity_test
