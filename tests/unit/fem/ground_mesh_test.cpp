// A ground of tetrahedra by its interface: static equilibrium, steps of all integrators on any
// number of ranks, restart, fields.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/boundary/terms.hpp"
#include "fem/mesh/flat_top.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/mesh_scene.hpp"
#include "unit/fem/pushed_top.hpp"

namespace trackbed::fem::ground_mesh_test {
namespace {

using par::Comm;

constexpr Elastic soil{60e6, 0.3, 1900};

// Two solids, a viscous base with springs, viscous sides along x, no parallel edges inside.
GroundParameters two_layers(const std::string& name) {
  const Vec3 size(2, 1.5, 1);
  const std::array<int, 3> cells = {4, 3, 3};
  TetBox box(size, cells, shaken(size, cells, 0.12));
  box.volumes = {"soil", "sand"};
  for (std::size_t e = 0; e < box.tetrahedron.size(); ++e) {
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k)
      z += 0.25 * box.node[static_cast<std::size_t>(box.tetrahedron[e][k])].z();
    box.volume[e] = z > -0.35 ? 1 : 0;
  }
  GroundParameters p = of_mesh(box, name, soil);
  p.solids[1].solid = {120e6, 0.25, 2000, 5, 2e-5};
  p.borders[0].holds = p.borders[1].holds = p.borders[4].holds = BorderKind::viscous;
  p.rayleigh_mass = 2;
  p.tolerance = 1e-11;
  return p;
}

double size_of(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

class Steps : public ::testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(, Steps,
                         ::testing::Values(Integrator::explicit_, Integrator::newmark,
                                           Integrator::hht, Integrator::bossak,
                                           Integrator::generalized_alpha));

// Explicit steps are bitwise identical, implicit ones agree to the solver's tolerance times steps.
TEST_P(Steps, AreTheSameOnAnyNumberOfRanks) {
  GroundParameters p = two_layers("steps" + std::to_string(static_cast<int>(GetParam())));
  p.integrator = GetParam();
  Ground alone(Comm::self(), p, Dimension::space, 1), shared(Comm::world(), p, Dimension::space, 1);
  ASSERT_EQ(alone.top().triangles, shared.top().triangles);
  double dt = 5e-4;
  if (GetParam() == Integrator::explicit_) {
    EXPECT_EQ(alone.stable_step(), shared.stable_step());
    dt = 2.5 * shared.stable_step();
  }
  for (Ground* ground : {&alone, &shared}) {
    ground->settle(uneven_load(ground->top(), 0));
    for (int w = 1; w < 20; ++w) ground->advance(dt, uneven_load(ground->top(), w));
    EXPECT_EQ(ground->trouble(), "");
  }
  const std::vector<double> one = shape_of(Comm::self(), alone);
  const std::vector<double> many = shape_of(Comm::world(), shared);
  EXPECT_GT(size_of(one), 1e-7);
  if (GetParam() == Integrator::explicit_)
    EXPECT_EQ(one, many);
  else
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(one[k], many[k], 1e-8 * size_of(one));
  EXPECT_EQ(shared.totals().elements, 216);
  EXPECT_EQ(shared.totals().nodes, 9 * 7 * 7);
}

// On all ranks, then on one: bitwise identical to an uninterrupted run.
TEST_P(Steps, ContinueFromACheckpoint) {
  GroundParameters p = two_layers("restart" + std::to_string(static_cast<int>(GetParam())));
  p.integrator = GetParam();
  const Comm world = Comm::world();
  Ground whole(world, p, Dimension::space, 1), second(world, p, Dimension::space, 1);
  const double dt = GetParam() == Integrator::explicit_ ? 2.5 * whole.stable_step() : 5e-4;
  whole.settle(uneven_load(whole.top(), 0));
  whole.begin_extremes();
  for (int w = 1; w < 6; ++w) whole.advance(dt, uneven_load(whole.top(), w)), whole.take_extremes();
  const std::string path =
      fmt::format("ground_mesh_{}_on_{}.h5", static_cast<int>(GetParam()), world.size());
  {
    io::File file(world, path, io::Mode::create);
    whole.save(file, "ground");
  }
  Ground alone(Comm::self(), p, Dimension::space, 1);
  {
    const io::File file(world, path, io::Mode::read);
    second.load(file, "ground"), alone.load(file, "ground");
  }
  for (int w = 6; w < 12; ++w)
    for (Ground* ground : {&whole, &second, &alone})
      ground->advance(dt, uneven_load(ground->top(), w));
  const std::vector<double> one = shape_of(world, whole), other = shape_of(world, second);
  EXPECT_EQ(one, other);
  const std::vector<double> by_one = shape_of(Comm::self(), alone);
  for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(one[k], by_one[k], 1e-8 * size_of(one));
  EXPECT_EQ(second.fields().cell_data.back().name, "extreme_least_vertical_stress");
}

// Weight and a surface load: sigma_z = rho g z - q, sigma_x = sigma_y = nu/(1-nu) sigma_z, exact in
// quadratic elements of any shape.
TEST(GroundOfTetrahedra, StressOfWeightIsProportionalToDepth) {
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {3, 2, 2};
  GroundParameters p =
      of_mesh(TetBox(size, cells, shaken(size, cells, 0.15)), "weight", {50e6, 0.3, 2000});
  p.tolerance = 1e-13;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  ground.settle(std::vector<Vec3>(ground.top().nodes(), Vec3::Zero()));
  const io::Grid grid = ground.fields();
  ASSERT_EQ(grid.kind, io::CellKind::quadratic_tetrahedron);
  const auto& rest = grid.cell_data[1];
  ASSERT_TRUE(rest.name.starts_with("stress_static"));
  const double weight = 2000 * gravity;
  for (std::size_t c = 0; c < grid.cells.size() / 10; ++c) {
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k)
      z += 0.25 * grid.points[static_cast<std::size_t>(grid.cells[10 * c + k])].z();
    EXPECT_NEAR(rest.values[6 * c + 2], weight * z, 1e-6 * weight);
    EXPECT_NEAR(rest.values[6 * c], 0.3 / 0.7 * weight * z, 1e-6 * weight);
    for (std::size_t k = 3; k < 6; ++k) EXPECT_NEAR(rest.values[6 * c + k], 0, 1e-6 * weight);
  }
  EXPECT_EQ(Comm::world().sum(static_cast<std::int64_t>(grid.cells.size() / 10)), 72);
}

// A mid-side node off its edge at the border of the top; rounding to six digits is accepted.
TEST(GroundOfTetrahedra, CurvedEdgesOfTheTopGiveAWarning) {
  TetBox box({2, 1, 1}, {2, 1, 1});
  const auto warnings = [&](double off, const std::string& name) {
    for (Vec3& at : box.node)
      if (at.x() == 0.5 && std::abs(at.y()) < 0.1 && at.z() == 0) at.y() = off;
    GroundParameters p = of_mesh(box, name, soil);
    p.borders[2].holds = BorderKind::fixed;  // no longer plane
    return look_at_mesh(p).warnings;
  };
  EXPECT_TRUE(warnings(0, "straight_top").empty());
  EXPECT_TRUE(warnings(5e-4, "six_digits").empty());
  const std::vector<std::string> reported = warnings(-0.02, "curved_top");
  ASSERT_EQ(reported.size(), 1);
  EXPECT_NE(reported[0].find("1 edges of the top are curved"), std::string::npos) << reported[0];
  EXPECT_NE(reported[0].find("by up to 2 % of the length of the edge, at (0.5, -0.02, 0) m"),
            std::string::npos)
      << reported[0];
}

// A column without lateral motion under 10 kPa: settlement q H (1 + nu)(1 - 2 nu) / (E (1 - nu)),
// and sigma_z = -q at its top. On flat triangles, as stones load them; exact in quadratic elements.
TEST(GroundOfTetrahedra, PressureOnItsTrianglesIsUniform) {
  const Vec3 size(1, 1, 2);
  const std::array<int, 3> cells = {3, 2, 3};
  GroundParameters p =
      of_mesh(TetBox(size, cells, shaken(size, cells, 0.15)), "compressed", {50e6, 0.3, 2000});
  p.integrator = Integrator::bossak, p.alpha = -0.3;
  p.tolerance = 1e-12;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  const std::vector<Vec3> force = pressure_forces(ground.top(), [](const Vec3&) { return 10e3; });
  for (int w = 0; w < 20; ++w) ground.advance(5, force);
  const double exact = 10e3 * 2 * 1.3 * 0.4 / (50e6 * 0.7);
  for (const std::int32_t n : ground.own_top()) {
    EXPECT_NEAR(ground.top_state(n).displacement.z(), -exact, 1e-6 * exact) << n;
    EXPECT_NEAR(ground.top_state(n).sigma_z, -10e3, 1e-6 * 10e3) << n;
  }
}

// Forces on the surface and on the nodes below have equal sum, moment and work.
TEST(GroundOfTetrahedra, ForcesOfTheSurfaceKeepMomentAndWork) {
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {3, 2, 2};
  for (const auto edges : {TetBox::Edges::straight, TetBox::Edges::curved}) {
    const bool curved = edges == TetBox::Edges::curved;
    const TetBox box(size, cells, shaken(size, cells, curved ? 0.03 : 0.1), edges);
    const GroundParameters p = of_mesh(box, curved ? "moment_curved" : "moment", soil);
    Mesh mesh(Comm::world(), p, Dimension::space, 1);
    const Terms terms(mesh, p, Stiffness(mesh, {}));
    const FlatTop top(mesh, terms.mass);
    Nodal force(3, mesh.nodes()), u(3, mesh.nodes());
    std::array<double, 3> above{}, below{};  // work, force, moment about y
    const auto numbered = [&](std::int32_t n, int c) {
      return std::sin(static_cast<double>((c + 2) * mesh.node[static_cast<std::size_t>(n)]));
    };
    for (int c = 0; c < 3; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n)
        u[c][n] = numbered(static_cast<std::int32_t>(n), c);
    const auto take = [&](std::array<double, 3>& to, std::int32_t n, const Vec3& way) {
      const Vec3 f(force[0][n], force[1][n], force[2][n]);
      to[0] += f.dot(way), to[1] += f.z(), to[2] += f.z() * mesh.position(n).x();
    };
    for (const Id id : mesh.imported->top_node)
      if (const std::int32_t n = mesh.local_node(id);
          n >= 0 && mesh.owned[static_cast<std::size_t>(n)] != 0) {
        for (int c = 0; c < 3; ++c) force[c][n] = numbered(n, c + 5);
        take(above, n, top.at(n, u));
      }
    top.to_nodes(force);
    for (const std::int32_t n : mesh.own) take(below, n, {u[0][n], u[1][n], u[2][n]});
    Comm::world().sum(std::span<double>(above)), Comm::world().sum(std::span<double>(below));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(above[k], below[k], 1e-12) << k;
    EXPECT_GT(std::abs(above[0]), 0.1);
  }
}

// The contact surface of stones: flat triangles with upward normals and the area of the top.
TEST(GroundOfTetrahedra, TopIsASurfaceOfTriangles) {
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {3, 2, 2};
  Ground ground(Comm::world(), of_mesh(TetBox(size, cells), "top", soil), Dimension::space, 1);
  EXPECT_EQ(ground.top().triangles.size(), 4 * 12u);
  double area = 0;
  for (const auto& t : ground.top().triangles) {
    const auto at = [&](std::size_t k) {
      return ground.top().position[static_cast<std::size_t>(t[k])];
    };
    const Vec3 half = 0.5 * (at(1) - at(0)).cross(at(2) - at(0));
    EXPECT_GT(half.z(), 0);
    area += half.z();
  }
  EXPECT_NEAR(area, 2, 1e-12);
}

}  // namespace
}  // namespace trackbed::fem::ground_mesh_test
