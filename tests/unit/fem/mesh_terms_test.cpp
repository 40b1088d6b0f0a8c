// Terms at the nodes of a ground of tetrahedra: dashpots of viscous borders, mass damping of each
// solid, and the critical explicit step.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fem/boundary/terms.hpp"
#include "trackbed/core/decompositions.hpp"
#include "unit/fem/mesh_scene.hpp"

namespace trackbed::fem::mesh_terms_test {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic soil{50e6, 0.3, 2000};

// A shaft of 1 m diameter with free sides on a viscous base.
GroundParameters shaft(const std::string& name) {
  const auto circular = [](const Vec3& at) {
    const double x = 2 * at.x() - 1, y = 2 * at.y() - 1;
    return Vec3(0.5 * x * std::sqrt(1 - y * y / 2), 0.5 * y * std::sqrt(1 - x * x / 2), at.z());
  };
  GroundParameters p = of_mesh(TetBox({1, 1, 4}, {2, 2, 12}, circular), name, soil);
  for (MeshBorder& border : p.borders) border.holds = BorderKind::free;
  p.borders[4].holds = BorderKind::viscous;
  p.base_stiffness = 0;
  p.integrator = Integrator::explicit_;
  return p;
}

// rho c_p and rho c_s over the area (Lysmer, Kuhlemeyer 1969).
TEST(TermsOfTetrahedra, DashpotsHaveTheImpedancesOfTheirDirections) {
  for (const std::size_t side : {std::size_t{0}, std::size_t{3}, std::size_t{4}}) {
    GroundParameters p = of_mesh(TetBox({2, 1, 3}, {2, 1, 2}), fmt::format("side_{}", side), soil);
    for (MeshBorder& border : p.borders) border.holds = BorderKind::free;
    p.borders[side].holds = BorderKind::viscous;
    const Mesh mesh(Comm::self(), p, Dimension::space, 1);
    const Terms terms(mesh, p, Stiffness(mesh, {}));
    const int normal = static_cast<int>(side / 2);
    const double area = 2.0 * 1 * 3 / Vec3(2, 1, 3)[normal];
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t n = 0; n < mesh.nodes(); ++n) sum += terms.damping[c][n];
      const double shear = 50e6 / 2.6, modulus = 50e6 * 0.7 / (1.3 * 0.4);
      const double exact = std::sqrt(2000 * (c == normal ? modulus : shear)) * area;
      EXPECT_NEAR(sum, exact, 1e-9 * exact) << side << ' ' << c;
    }
  }
}

// A twist of its top travels down a circular shaft as a shear wave and leaves through the base:
// dashpots of normal impedance would reflect ((a - 1)/(a + 1))^2 = 9 % of its energy, a = c_p/c_s.
TEST(TermsOfTetrahedra, ShearWaveLeavesThroughAViscousBase) {
  Ground ground(Comm::world(), shaft("shaft"), Dimension::space, 1);
  std::vector<Vec3> twist(ground.top().nodes(), Vec3::Zero());
  for (const auto& t : ground.top().triangles)
    for (const std::int32_t n : t) {
      const Vec3& at = ground.top().position[static_cast<std::size_t>(n)];
      twist[static_cast<std::size_t>(n)] += 1e3 * Vec3(-at.y(), at.x(), 0);
    }
  // c_s = 98 m/s: 41 ms down.
  constexpr double dt = 1e-3, pulse = 0.03;
  double most = 0, left = 0;
  for (int w = 0; w < 90; ++w) {
    const double t = (w + 0.5) * dt;
    std::vector<Vec3> force = twist;
    for (Vec3& f : force) f *= t < pulse ? std::pow(std::sin(pi * t / pulse), 2) : 0;
    ground.advance(dt, force);
    const GroundTotals totals = ground.totals();
    left = totals.kinetic + totals.elastic;
    most = std::max(most, left);
  }
  EXPECT_LT(left, 0.02 * most);
}

// Two solids, the lower half and the upper one.
GroundParameters halves(const std::string& name) {
  TetBox box({1, 1, 2}, {1, 1, 8});
  box.volumes = {"lower", "upper"};
  for (std::size_t e = 0; e < box.tetrahedron.size(); ++e) {
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k)
      z += 0.25 * box.node[static_cast<std::size_t>(box.tetrahedron[e][k])].z();
    box.volume[e] = z > -1 ? 1 : 0;
  }
  GroundParameters p = of_mesh(box, name, soil);
  p.rayleigh_mass = 2;
  p.integrator = Integrator::explicit_;
  return p;
}

TEST(TermsOfTetrahedra, MassDampingIsThatOfEachSolid) {
  GroundParameters p = halves("halves");
  p.solids[0].solid.rayleigh_mass = 3, p.solids[1].solid.rayleigh_mass = 7;
  const Mesh mesh(Comm::self(), p, Dimension::space, 1);
  const Terms terms(mesh, p, Stiffness(mesh, {}));
  for (std::size_t n = 0; n < mesh.nodes(); ++n) {
    const double z = mesh.position(static_cast<std::int32_t>(n)).z();
    if (std::abs(z + 1) < 1e-9) continue;  // nodes of both
    const double rate = z < -1 ? 3 : 7;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(terms.damping[c][n], rate * terms.mass[n], 1e-9 * terms.mass[n]);
  }
}

// A column released from a deflection vibrates with c_p / 4 H; the energy of all its modes decays
// as exp(-alpha t) with the damping of its solids, 5/s, not of the ground, 2/s.
TEST(TermsOfTetrahedra, FreeVibrationDecaysByTheSolidsMassDamping) {
  GroundParameters p = halves("decay");
  for (MeshSolid& solid : p.solids) solid.solid.rayleigh_mass = 5;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  std::vector<Vec3> none(ground.top().nodes(), Vec3::Zero());
  ground.settle(pressure_forces(ground.top(), [](const Vec3&) { return 10e3; }));
  const double period = 4 * 2 / std::sqrt(50e6 * 0.7 / (1.3 * 0.4) / 2000);
  constexpr int windows = 100;  // of a period
  std::array<double, 5> kinetic{};
  for (double& sum : kinetic)
    for (int w = 0; w < windows; ++w) {
      ground.advance(period / windows, none);
      sum += ground.totals().kinetic;
    }
  const double exact = std::exp(-5 * 4 * period);
  EXPECT_NEAR(kinetic[4] / kinetic[0], exact, 0.02 * exact);
}

// Largest frequency of M^-1 (K + springs) over free degrees of freedom, rad/s: power iteration.
double largest_frequency(const Mesh& mesh, const Stiffness& stiffness, const Terms& terms) {
  Nodal u(3, mesh.nodes()), f(3, mesh.nodes());
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
      u[c][n] = std::sin(12.9898 * static_cast<double>(n) + 78.233 * c);
  double squared = 0;
  for (int iteration = 0; iteration < 2000; ++iteration) {
    stiffness.apply(u, f);
    for (const Spring& s : terms.springs)
      for (int c = 0; c < 3; ++c) f[c][s.node] += s.stiffness * u[c][s.node];
    double above = 0, below = 0;
    for (int c = 0; c < 3; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n) {
        if ((terms.held[n] >> c & 1) != 0) f[c][n] = u[c][n] = 0;
        above += u[c][n] * f[c][n], below += terms.mass[n] * u[c][n] * u[c][n];
        f[c][n] /= terms.mass[n];
      }
    squared = above / below;
    const double scale = 1 / std::sqrt(below) / squared;
    for (int c = 0; c < 3; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n) u[c][n] = scale * f[c][n];
  }
  return std::sqrt(squared);
}

// One free tetrahedron: its frequency is that of the mesh.
GroundParameters one_tetrahedron() {
  TetBox box({1, 1, 1}, {1, 1, 1});
  box.node = {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(1.2, 0, 0), Vec3(0.2, 0.1, -0.8)};
  constexpr std::array<std::array<std::size_t, 2>, 6> ends = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}}};  // Gmsh's order
  for (const auto& [a, b] : ends) box.node.push_back((box.node[a] + box.node[b]) / 2);
  box.tetrahedron = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}, box.volume = {0};
  box.face = {{{0, 2, 1, 6, 5, 4}, 5}};
  GroundParameters p = of_mesh(box, "one", soil);
  for (MeshBorder& border : p.borders) border.holds = BorderKind::free;
  p.integrator = Integrator::explicit_;
  return p;
}

double bound_of(const GroundParameters& p, double& largest) {
  const Mesh mesh(Comm::self(), p, Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  largest = 2 / largest_frequency(mesh, stiffness, Terms(mesh, p, stiffness));
  std::string limit;
  return critical_step_of_tetrahedra(mesh, p, stiffness, limit);
}

// s, without springs on borders and damping: from the eigenvalues of each element; and the number
// of the first one with the shortest step.
std::pair<double, std::size_t> step_of_all_elements(const Mesh& mesh, const Stiffness& stiffness) {
  std::pair<double, std::size_t> found{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    TenNodes nodes;
    for (int k = 0; k < 10; ++k)
      nodes[static_cast<std::size_t>(k)] = mesh.position(mesh.corner(z, k));
    const double mass = soil.density * tetrahedron_volume(nodes);
    Eigen::VectorXd root(30);
    for (int f = 0; f < 30; ++f) root[f] = 1 / std::sqrt(mass * tetrahedron_mass_fraction(f / 3));
    const Eigen::MatrixXd scaled =
        root.asDiagonal() * stiffness.matrix(mesh, z) * root.asDiagonal();
    const double step = 2 / std::sqrt(symmetric_eigenvalues(scaled).maxCoeff());
    if (step < found.first) found = {step, z};
  }
  return found;
}

TEST(TermsOfTetrahedra, CriticalStepIsTheShortestOfAllElements) {
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {3, 2, 2};
  for (const double shake : {0.0, 0.1, 0.2, 0.3}) {  // with 0 many elements are equal
    GroundParameters p = of_mesh(TetBox(size, cells, shaken(size, cells, shake)), "all", soil);
    p.integrator = Integrator::explicit_;
    const Mesh mesh(Comm::self(), p, Dimension::space, 1);
    const Stiffness stiffness(mesh, {});
    std::string limit;
    const double step = critical_step_of_tetrahedra(mesh, p, stiffness, limit);
    const auto [shortest, element] = step_of_all_elements(mesh, stiffness);
    EXPECT_NEAR(step, shortest, 1e-12 * shortest) << shake;
    EXPECT_NE(limit.find(fmt::format("number {} in the file", element + 1)), std::string::npos)
        << limit;
  }
}

TEST(TermsOfTetrahedra, CriticalStepIsNotAboveTheLimitOfTheMesh) {
  double largest = 0;
  const double alone = bound_of(one_tetrahedron(), largest);
  EXPECT_NEAR(alone, largest, 1e-6 * largest);
  const Vec3 size(2, 1, 1);
  const std::array<int, 3> cells = {3, 2, 2};
  GroundParameters p = of_mesh(TetBox(size, cells, shaken(size, cells, 0.2)), "bound", soil);
  p.borders[4].holds = BorderKind::viscous, p.base_stiffness = 5e9;  // stiffer than the solid
  p.integrator = Integrator::explicit_;
  const double bound = bound_of(p, largest);
  EXPECT_LT(bound, largest);
  EXPECT_GT(bound, 0.5 * largest);
}

// Energy after an initial impulse.
double energy_after(double safety, int steps) {
  GroundParameters p = one_tetrahedron();
  p.safety = safety;
  Ground ground(Comm::self(), p, Dimension::space, 1);
  std::vector<Vec3> force(ground.top().nodes(), Vec3::Zero());
  force[0] = {100, 200, -300};
  const double dt = ground.stable_step();
  ground.advance(dt, force);
  std::fill(force.begin(), force.end(), Vec3::Zero());
  for (int s = 0; s < steps; ++s) ground.advance(dt, force);
  return ground.totals().elastic;
}

TEST(TermsOfTetrahedra, StepsUpToTheCriticalOneAreStable) {
  EXPECT_LT(energy_after(0.99, 2000), 100 * energy_after(0.5, 10));
  const double beyond = energy_after(1.02, 2000);
  EXPECT_FALSE(beyond < 1e6 * energy_after(0.5, 10));
}

}  // namespace
}  // namespace trackbed::fem::mesh_terms_test
