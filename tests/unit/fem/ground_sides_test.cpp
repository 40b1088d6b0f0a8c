// Sides with individual conditions: a plane of symmetry halves the model, effects of one side stay
// at that side, and bitwise identity holds.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/boundary/free_field.hpp"
#include "fem/boundary/terms.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/compared.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem::ground_sides_test {
namespace {

using par::Comm;

class SidesIn : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, SidesIn, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// Symmetric about x = 0 and y = 0: two layers, a block, damping of both kinds.
GroundParameters symmetric(Integrator integrator) {
  GroundParameters p = box({1, 1, 1}, {8, 4, 6}, {});
  p.x = {-4, 4}, p.y = {-2, 2};
  p.layers = {{"soft", 1, {60e6, 0.35, 1700}}, {"stiff", 2, {200e6, 0.3, 2000}}};
  p.blocks = {{"block", true, {-1, 0, 1, 0, 1, -1, -1, -1}, {900e6, 0.2, 2400}}};
  p.rayleigh_mass = 3, p.rayleigh_stiffness = 2e-5;
  p.plane = PlaneState::strain;
  p.sides = Sides::viscous;
  p.integrator = integrator;
  p.tolerance = 1e-12;
  return p;
}

// Traction symmetric in x and y, with antisymmetric components across the planes, Pa.
Vec3 even(const Vec3& at) {
  const double x = std::abs(at.x()), y = std::abs(at.y());
  return 1e3 * Vec3(at.x() * (1 + y), at.y() * (2 - 0.3 * x), -20 + 5 * x + 3 * y * x);
}

double half_from_whole(const GroundParameters& whole, const GroundParameters& half,
                       Dimension dimension) {
  const Comm comm = Comm::world();
  Ground all(Comm::self(), whole, dimension, 1.0), part(comm, half, dimension, 1.0);
  EXPECT_DOUBLE_EQ(all.stable_step(), part.stable_step());
  double worst = 0;
  for (Ground* ground : {&all, &part}) ground->settle(none(*ground));
  const auto on_all = traction_forces(all, even), on_part = traction_forces(part, even);
  for (int w = 0; w < 40; ++w) {
    all.advance(4e-4, w < 15 ? on_all : none(all));
    part.advance(4e-4, w < 15 ? on_part : none(part));
    if (w % 10 == 9)
      worst = std::max(worst, apart(comm, part, all, [](const Vec3& at) { return at; }));
  }
  return worst;
}

// Rounding of forces that cancel by symmetry, over some hundred steps; the solver's tolerance.
double bound(Integrator integrator) { return integrator == Integrator::explicit_ ? 1e-10 : 1e-7; }

TEST_P(SidesIn, RollerAlongTheTrackIsAPlaneOfSymmetry) {
  for (const Integrator integrator : {Integrator::explicit_, Integrator::generalized_alpha}) {
    const GroundParameters whole = symmetric(integrator);
    GroundParameters half = whole;
    half.x = {0, 4}, half.elements_x = 4;
    half.side_x_low = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, GetParam()), bound(integrator));
    half.side_x_low = Sides::as_sides;
    EXPECT_GT(half_from_whole(whole, half, GetParam()), 1e-3);
    half.x = {-4, 0};
    half.side_x_high = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, GetParam()), bound(integrator));
  }
}

TEST(SidesAcross, RollerIsAPlaneOfSymmetry) {
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    const GroundParameters whole = symmetric(integrator);
    GroundParameters half = whole;
    half.y = {0, 2}, half.elements_y = 2;
    half.side_y_low = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, Dimension::space), bound(integrator));
    half.y = {-2, 0};
    half.side_y_low = Sides::as_sides, half.side_y_high = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, Dimension::space), bound(integrator));
  }
}

// A block on each side of the whole, one in the half.
TEST(SidesAcross, BlocksAreInPlace) {
  GroundParameters whole = symmetric(Integrator::explicit_);
  whole.blocks.push_back(whole.blocks[0]);
  whole.blocks[0].y = {1, 2}, whole.blocks[1].y = {-2, -1};
  GroundParameters half = whole;
  half.y = {0, 2}, half.elements_y = 2;
  half.side_y_low = Sides::roller;
  half.blocks.pop_back();
  EXPECT_LT(half_from_whole(whole, half, Dimension::space), bound(Integrator::explicit_));
  half.blocks[0].y = {0, 1};
  EXPECT_GT(half_from_whole(whole, half, Dimension::space), 1e-3);
}

// The wave is symmetric about a plane along the track for any direction, about one across only if
// vertical.
TEST(SidesAcross, RollerIsAPlaneOfSymmetryOfAWave) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    GroundParameters whole = symmetric(integrator);
    whole.sides = Sides::free_field;
    whole.base_motion = wave_table(comm, "both", {80, 0.008}, 2.0, 3.0, 2e-4);
    GroundParameters half = whole;
    half.y = {0, 2}, half.elements_y = 2;
    half.side_y_low = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, Dimension::space), bound(integrator));
    whole.base_motion = wave_table(comm, "upwards", {80, 0.008}, 0, 3.0, 2e-4);
    half = whole;
    half.x = {0, 4}, half.elements_x = 4;
    half.side_x_low = Sides::roller;
    EXPECT_LT(half_from_whole(whole, half, Dimension::space), bound(integrator));
  }
}

// Weight and dead load: the static stresses of the half are those of the whole.
TEST(SidesAcross, StaticSolutionOfTheHalfIsThatOfTheWhole) {
  GroundParameters whole = symmetric(Integrator::newmark), half = whole;
  half.y = {0, 2}, half.elements_y = 2;
  half.side_y_low = Sides::roller;
  Ground all(Comm::self(), whole, Dimension::space, 1),
      part(Comm::self(), half, Dimension::space, 1);
  for (Ground* ground : {&all, &part}) ground->settle(traction_forces(*ground, even));
  const io::Grid full = all.fields(), cut = part.fields();
  const auto centre = [](const io::Grid& grid, std::size_t cell) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      sum += grid.points[static_cast<std::size_t>(grid.cells[8 * cell + k])] / 8;
    return sum;
  };
  double worst = 0, largest = 0;
  for (std::size_t c = 0; c < cut.cells.size() / 8; ++c)
    for (std::size_t d = 0; d < full.cells.size() / 8; ++d) {
      if ((centre(cut, c) - centre(full, d)).norm() > 1e-9) continue;
      for (std::size_t s = 0; s < 6; ++s) {
        const double here = cut.cell_data[1].values[6 * c + s];
        worst = std::max(worst, std::abs(here - full.cell_data[1].values[6 * d + s]));
        largest = std::max(largest, std::abs(here));
      }
    }
  EXPECT_GT(largest, 3e4);
  EXPECT_LT(worst, 1e-7 * largest);
}

// At the edge of two sides constraints of both hold, dashpots are those of viscous ones only.
TEST(SidesAcross, EachActsOnlyOnItself) {
  GroundParameters p = box({4, 4, 4}, {2, 2, 2}, {80e6, 0.3, 1900});
  p.side_x_low = Sides::fixed, p.side_x_high = Sides::free;
  p.side_y_low = Sides::roller, p.side_y_high = Sides::viscous;
  const Mesh mesh(Comm::self(), p, Dimension::space, 1);
  const Stiffness stiffness(
      mesh, {element_matrices({2, 2, 2}, p.layers[0].solid, Dimension::space, PlaneState::stress)});
  const Terms terms(mesh, p, stiffness);
  const auto at = [&](std::int64_t i, std::int64_t j) {  // at mid-height
    return static_cast<std::size_t>(mesh.local_node(mesh.lattice.node({i, j, 1})));
  };
  // Constraints in motion, then in the static solve.
  using Bits = std::array<int, 2>;
  const auto held = [&](std::int64_t i, std::int64_t j) {
    return Bits{terms.held[at(i, j)], terms.held_static[at(i, j)]};
  };
  const Impedance of = impedance(p.layers[0].solid, false);
  const auto viscous = [&](std::int64_t i, std::int64_t j, double area) {
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(terms.damping[c][static_cast<std::ptrdiff_t>(at(i, j))],
                  area * (c == 1 ? of.normal : of.tangential), 1e-6);
  };
  for (std::int64_t j = 0; j <= 2; ++j) EXPECT_EQ(held(0, j), (Bits{7, 7}));
  for (std::int64_t i = 1; i <= 2; ++i) {
    EXPECT_EQ(held(i, 0), (Bits{2, 2}));
    EXPECT_EQ(held(i, 1), (Bits{0, 0}));
    EXPECT_EQ(held(i, 2), (Bits{0, 2}));
    viscous(i, 0, 0), viscous(i, 1, 0);
  }
  viscous(0, 2, 2), viscous(1, 2, 4), viscous(2, 2, 2);
  viscous(2, 0, 0);
}

// The columns beside one side have no effect on the adjacent side: a level ground between rollers
// along the track moves uniformly.
TEST_P(SidesIn, FreeFieldBesideRollersHasNoEffect) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    GroundParameters p = symmetric(integrator);
    p.blocks.clear();
    p.side_x_low = p.side_x_high = Sides::free_field;
    p.side_y_low = p.side_y_high = Sides::roller;
    p.base_motion = wave_table(comm, "beside", {50, 0.03}, 1.0, 0.7, 5e-4);
    Ground ground(comm, p, GetParam(), 1.0);
    ground.settle(none(ground));
    const Spread found = spread_in_a_wave(comm, ground);
    EXPECT_GT(found.largest, 1e-6);
    EXPECT_LT(found.apart / found.largest, integrator == Integrator::explicit_ ? 1e-11 : 1e-8);
  }
}

// Forces of the columns on free sides across the track would be those of a continuous ground.
TEST(SidesAcross, ColumnsActOnlyOnTheirOwnSide) {
  for (const Sides across : {Sides::free, Sides::free_field}) {
    GroundParameters p = symmetric(Integrator::explicit_);
    p.sides = Sides::free_field;
    p.side_y_low = p.side_y_high = across;
    p.base_motion = wave_table(Comm::world(), "columns", {80, 0.008}, 2.0, 3.0, 2e-4);
    const Mesh mesh(Comm::self(), p, Dimension::space, 1);
    std::vector<ElementMatrices> elements;
    for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
      elements.push_back(
          element_matrices(mesh.solids.size[s], mesh.solids.solid[s], Dimension::space, p.plane));
    const Stiffness stiffness(mesh, elements);
    FreeField columns(mesh, p, stiffness);
    for (int step = 1; step <= 40; ++step) columns.explicit_step(2e-4, step * 2e-4);
    Nodal force(3, mesh.nodes());
    columns.act_on(force);
    std::array<double, 3> most{};
    for (int c = 0; c < 3; ++c)
      for (const std::int32_t n : mesh.own)
        most[static_cast<std::size_t>(c)] =
            std::max(most[static_cast<std::size_t>(c)], std::abs(force[c][n]));
    EXPECT_GT(most[0], 1e3);
    if (across == Sides::free)
      EXPECT_LT(most[1], 1e-9 * most[0]);
    else
      EXPECT_GT(most[1], 1e-2 * most[0]);
  }
}

// All kinds at once, with a wave and an uneven load.
GroundParameters mixed(Integrator integrator) {
  GroundParameters p = symmetric(integrator);
  p.side_x_low = Sides::fixed, p.side_x_high = Sides::free_field;
  p.side_y_low = Sides::roller, p.side_y_high = Sides::viscous;
  p.base_motion = wave_table(Comm::world(), "mixed", {80, 0.008}, 2.0, 3.0, 2e-4);
  return p;
}

TEST_P(SidesIn, MixedAreBitwiseIdenticalOnAnyRankCount) {
  const Comm world = Comm::world();
  const GroundParameters p = mixed(Integrator::explicit_);
  Ground alone(Comm::self(), p, GetParam(), 1.0), spread(world, p, GetParam(), 1.0);
  for (Ground* ground : {&alone, &spread}) {
    ground->settle(none(*ground));
    for (int w = 0; w < 30; ++w) ground->advance(5e-4, load_of(ground->top(), w));
  }
  EXPECT_EQ(bits(Comm::self(), alone), bits(world, spread));
  EXPECT_GT(alone.totals().kinetic, 0);
}

TEST_P(SidesIn, MixedContinueBitwiseIdentically) {
  const Comm world = Comm::world(), self = Comm::self();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::hht}) {
    const bool one = integrator != Integrator::explicit_;  // implicit results depend on the ranks
    const Comm& comm = one ? self : world;
    const GroundParameters p = mixed(integrator);
    const std::string path =
        fmt::format("mixed_sides_{}_{}.h5", world.size(), one ? world.rank() + 1 : 0);
    Ground straight(comm, p, GetParam(), 1.0), resumed(comm, p, GetParam(), 1.0);
    straight.settle(none(straight));
    for (int w = 0; w < 12; ++w) straight.advance(5e-4, load_of(straight.top(), w));
    {
      io::File file(comm, path, io::Mode::create);
      straight.save(file, "ground");
    }
    {
      const io::File file(comm, path, io::Mode::read);
      resumed.load(file, "ground");
    }
    for (Ground* ground : {&straight, &resumed})
      for (int w = 0; w < 12; ++w) ground->advance(5e-4, load_of(ground->top(), w));
    EXPECT_EQ(bits(comm, straight), bits(comm, resumed));
  }
}

}  // namespace
}  // namespace trackbed::fem::ground_sides_test
