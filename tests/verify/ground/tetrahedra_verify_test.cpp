// Ten-node tetrahedra from a mesh file: patch test, order, bending, near incompressibility,
// frequencies, waves through a viscous base.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "fem/boundary/terms.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "fem/solver/linear_system.hpp"
#include "support/verified.hpp"
#include "trackbed/core/decompositions.hpp"
#include "unit/fem/mesh_scene.hpp"

namespace trackbed::fem::tetrahedra_verify_test {
namespace {

using par::Comm;
using std::numbers::pi;

// Stiffness as a matrix, N/m: component * nodes + node. For some hundred nodes.
Eigen::MatrixXd matrix_of(const Mesh& mesh, const Stiffness& stiffness) {
  const auto n = static_cast<Eigen::Index>(mesh.nodes());
  Eigen::MatrixXd k(3 * n, 3 * n);
  Nodal u(3, mesh.nodes()), f(3, mesh.nodes());
  for (int c = 0; c < 3; ++c)
    for (Eigen::Index j = 0; j < n; ++j) {
      u[c][j] = 1;
      stiffness.apply(u, f);
      u[c][j] = 0;
      for (int e = 0; e < 3; ++e)
        for (Eigen::Index i = 0; i < n; ++i) k(e * n + i, c * n + j) = f[e][i];
    }
  return k;
}

bool on_face(const Vec3& x, const Vec3& size) {
  bool on = std::abs(x.z()) < 1e-9 || std::abs(x.z() + size.z()) < 1e-9;
  for (int a = 0; a < 2; ++a) on = on || std::abs(x[a]) < 1e-9 || std::abs(x[a] - size[a]) < 1e-9;
  return on;
}

// A linear motion of the faces of a box: all inner nodes must follow it.
TEST(PatchOfTetrahedra, KeepsConstantStress) {
  const Vec3 size(1, 1, 1);
  const std::array<int, 3> cells = {3, 3, 3};
  Mat3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -7e-4, 1e-4, 2e-4, 6e-4, 4e-4;
  for (const auto edges : {TetBox::Edges::straight, TetBox::Edges::curved}) {
    const bool straight = edges == TetBox::Edges::straight;
    const TetBox box(size, cells, shaken(size, cells, straight ? 0.2 : 0.05), edges);
    const Mesh mesh(Comm::self(), of_mesh(box, straight ? "patch" : "patch_curved", {1e8, 0.3, 1}),
                    Dimension::space, 1);
    const Stiffness stiffness(mesh, {});
    const Eigen::MatrixXd k = matrix_of(mesh, stiffness);
    const auto n = static_cast<Eigen::Index>(mesh.nodes());
    std::vector<Eigen::Index> inside;
    Eigen::VectorXd exact(3 * n), outer(3 * n);
    for (Eigen::Index node = 0; node < n; ++node) {
      const Vec3 at = mesh.position(static_cast<std::int32_t>(node));
      const bool face = on_face(at, size);
      for (int c = 0; c < 3; ++c) {
        const Eigen::Index row = c * n + node;
        exact[row] = (gradient * at)[c];
        outer[row] = face ? exact[row] : 0;
        if (!face) inside.push_back(row);
      }
    }
    const Eigen::VectorXd force = k * outer;
    const Eigen::VectorXd found = k(inside, inside).ldlt().solve(-force(inside));
    const verified::Limit rounding{4e-13, "rounding times the condition, 1e3, four times"};
    const verified::Limit curved{1e-4,
                                 "four points do not integrate curved edges exactly: 4e-5, twice"};
    verified::below(fmt::format("error of inner nodes over the motion, {} edges",
                                straight ? "straight" : "curved"),
                    "-",
                    (found - exact(inside)).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff(),
                    straight ? rounding : curved);
  }
}

// Consistent mass of a straight element over its mass: 420 times the entries.
double shared_mass(int a, int b) {
  constexpr std::array<std::array<int, 2>, 6> ends = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  if (a > b) std::swap(a, b);
  if (b < 4) return a == b ? 6 : 1;
  const auto& edge = ends[static_cast<std::size_t>(b - 4)];
  if (a < 4) return edge[0] == a || edge[1] == a ? -4 : -6;
  if (a == b) return 32;
  const auto& other = ends[static_cast<std::size_t>(a - 4)];
  const bool meet =
      other[0] == edge[0] || other[0] == edge[1] || other[1] == edge[0] || other[1] == edge[1];
  return meet ? 16 : 8;
}

TenNodes places(const Mesh& mesh, std::size_t element) {
  TenNodes nodes;
  for (int k = 0; k < 10; ++k)
    nodes[static_cast<std::size_t>(k)] = mesh.position(mesh.corner(element, k));
  return nodes;
}

// u = a sin(pi x) sin(pi y) sin(pi z), a = (1, 2, -1), and -div sigma for E = 1.
struct Manufactured {
  double nu;
  Vec3 displacement(const Vec3& x) const {
    return Vec3(1, 2, -1) * std::sin(pi * x.x()) * std::sin(pi * x.y()) * std::sin(pi * x.z());
  }
  Vec3 force(const Vec3& x) const {
    const double mu = 1 / (2 * (1 + nu)), lambda = nu / ((1 + nu) * (1 - 2 * nu));
    const Vec3 a(1, 2, -1), s = (pi * x).array().sin().matrix(),
                            c = (pi * x).array().cos().matrix();
    Vec3 f = 3 * mu * pi * pi * displacement(x);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double mixed = i == j ? -s.prod() : 1;  // d2/dx_i dx_j of the product of sines over pi^2
        for (int k = 0; k < 3 && i != j; ++k) mixed *= k == i || k == j ? c[k] : s[k];
        f[i] -= (lambda + mu) * a[j] * pi * pi * mixed;
      }
    return f;
  }
};

// Root mean square of the error at the Gauss points, over that of the solution.
double manufactured_error(int cells, double nu) {
  const auto bulge = [](const Vec3& x) {
    const double s = std::sin(pi * x.x()) * std::sin(pi * x.y()) * std::sin(pi * x.z());
    return Vec3(x + 0.06 * s * Vec3(1, -0.7, 0.5));
  };
  const TetBox box({1, 1, 1}, {cells, cells, cells}, bulge);
  Mesh mesh(Comm::world(), of_mesh(box, fmt::format("order_{}", cells), {1, nu, 1}),
            Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  const Manufactured exact{nu};
  std::vector<std::uint8_t> held(mesh.nodes(), 0);
  for (std::size_t n = 0; n < mesh.nodes(); ++n)
    held[n] = on_face(mesh.position(static_cast<std::int32_t>(n)), {1, 1, 1}) ? 7 : 0;
  Nodal force(3, mesh.nodes()), u(3, mesh.nodes());
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    const TenNodes nodes = places(mesh, e);
    const double volume = tetrahedron_volume(nodes);
    for (int b = 0; b < 10; ++b) {
      const Vec3 f = exact.force(nodes[static_cast<std::size_t>(b)]);
      for (int a = 0; a < 10; ++a)
        for (int c = 0; c < 3; ++c)
          force[c][mesh.corner(e, a)] += volume / 420 * shared_mass(a, b) * f[c];
    }
  }
  LinearSystem::Spec spec{{1.0}, Nodal(3, mesh.nodes()), held, 1e-11};
  LinearSystem(mesh, stiffness, spec).solve(force, u);
  mesh.exchange(u);
  double error = 0, all = 0;
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    if (!mesh.writes(e)) continue;
    const TenNodes nodes = places(mesh, e);
    for (int g = 0; g < tetrahedron_points; ++g) {
      const TenNumbers shape = tetrahedron_shape(tetrahedron_point(g));
      const double volume = tetrahedron_jacobian(nodes, tetrahedron_point(g)).determinant();
      Vec3 at = Vec3::Zero(), found = Vec3::Zero();
      for (int k = 0; k < 10; ++k) {
        const std::int32_t n = mesh.corner(e, k);
        at += shape[k] * nodes[static_cast<std::size_t>(k)];
        found += shape[k] * Vec3(u[0][n], u[1][n], u[2][n]);
      }
      error += volume * (found - exact.displacement(at)).squaredNorm();
      all += volume * exact.displacement(at).squaredNorm();
    }
  }
  return std::sqrt(Comm::world().sum(error) / Comm::world().sum(all));
}

TEST(Tetrahedra, ManufacturedSolutionConvergesWithOrderThree) {
  // Longest edges are sqrt(3)/8 of the box.
  const verified::Limit interpolated{
      5e-3,
      "quadratic displacement on the longest edges: (sqrt(3) pi / 8)^3 / 125 = 2.5e-3, twice"};
  const verified::Tolerance finer{0.35,
                                  "third order; curved edges, and k h = pi / 4 at the coarser"};
  const verified::Tolerance coarser{0.8, "third order; half a wave on two cells, k h = pi / 2"};
  for (const double nu : {0.3, 0.49}) {
    const double coarse = manufactured_error(2, nu), middle = manufactured_error(4, nu),
                 fine = manufactured_error(8, nu);
    verified::near(fmt::format("order of displacement, nu = {:g}", nu), "-",
                   std::log2(middle / fine), 3, finer);
    verified::near(fmt::format("order of displacement, 2 and 4 cells, nu = {:g}", nu), "-",
                   std::log2(coarse / middle), 3, coarser);
    verified::below(fmt::format("error with 8 cells along an edge, nu = {:g}", nu), "-", fine,
                    interpolated);
  }
}

// As Cantilever.BendsWithoutLocking for hexahedra: w = F L^3/(3 E I) + F L/(kappa G A).
double deflection(int across, double nu) {
  GroundParameters p = of_mesh(TetBox({1, 1, 20}, {across, across, 20 * across}),
                               fmt::format("beam_{}_{:g}", across, nu), {1e9, nu, 1e-6});
  for (std::size_t s = 0; s < 4; ++s) p.borders[s].holds = BorderKind::free;
  Mesh mesh(Comm::world(), p, Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  const Terms terms(mesh, p, stiffness);
  LinearSystem::Spec spec{{1.0}, Nodal(3, mesh.nodes()), terms.held, 1e-9};
  LinearSystem system(mesh, stiffness, spec);
  Nodal force(3, mesh.nodes()), u(3, mesh.nodes());
  const Imported& shape = *mesh.imported;
  for (const auto& t : shape.top_triangles)
    for (const std::int32_t k : t) {
      const std::int32_t n = mesh.local_node(shape.top_node[static_cast<std::size_t>(k)]);
      // Equal triangles; forces of ghosts are not read.
      if (n >= 0) force[0][n] += 1000.0 / (8 * across * across) / 3;
    }
  system.solve(force, u);
  double tip = 0;
  for (const auto n : mesh.own) tip = std::max(tip, u[0][n]);
  return Comm::world().max(tip);
}

TEST(Tetrahedra, BendWithoutLocking) {
  const auto exact = [](double nu) {
    const double shear = 1e9 / (2 * (1 + nu));
    return 1000.0 * 8000 / (3 * 1e9 / 12) + 1000.0 * 20 / (5.0 / 6 * shear);
  };
  const verified::Tolerance clamp{
      0.02, "the clamp prevents lateral strain: shorter by a tenth of the height, 1.5 %"};
  verified::near("deflection, one cell across, nu = 0.3", "m", deflection(1, 0.3), exact(0.3),
                 clamp.of(exact(0.3)));
  verified::near("deflection, two cells across, nu = 0.3", "m", deflection(2, 0.3), exact(0.3),
                 clamp.of(exact(0.3)));
  // Locking would give almost no deflection.
  const verified::Tolerance one{
      0.1, "separates from locking, which leaves almost no deflection; 7 % stiff"};
  const verified::Tolerance two{0.05, "separates from locking; half as stiff as one cell"};
  verified::near("deflection, one cell across, nu = 0.4999", "m", deflection(1, 0.4999),
                 exact(0.4999), one.of(exact(0.4999)));
  verified::near("deflection, two cells across, nu = 0.4999", "m", deflection(2, 0.4999),
                 exact(0.4999), two.of(exact(0.4999)));
}

// Lame's mode of a free cube, as Block.FreeVibration for hexahedra.
TEST(Tetrahedra, FreeVibration) {
  constexpr Elastic solid{50e6, 0.3, 2000};
  const double c_s = std::sqrt(solid.young / (2 * (1 + solid.poisson)) / solid.density);
  const double exact = std::sqrt(2.0) * pi * c_s;  // rad/s, of an edge of 1 m
  std::array<double, 2> error{};
  const verified::Limit rounding{
      1e-10, "rounding: 1e-16 of the largest, 1e3 times Lame's, of 1e3 frequencies squared"};
  for (const int fine : {0, 1}) {
    const int cells = fine == 0 ? 2 : 3;
    GroundParameters p =
        of_mesh(TetBox({1, 1, 1}, {cells, cells, cells}), fmt::format("block_{}", cells), solid);
    for (MeshBorder& border : p.borders) border.holds = BorderKind::free;
    const Mesh mesh(Comm::self(), p, Dimension::space, 1);
    const Stiffness stiffness(mesh, {});
    const Terms terms(mesh, p, stiffness);
    Eigen::VectorXd root(3 * static_cast<Eigen::Index>(mesh.nodes()));
    for (Eigen::Index k = 0; k < root.size(); ++k)
      root[k] = 1 / std::sqrt(terms.mass[static_cast<std::size_t>(k) % mesh.nodes()]);
    const Eigen::MatrixXd k = root.asDiagonal() * matrix_of(mesh, stiffness) * root.asDiagonal();
    const Eigen::VectorXd squared = symmetric_eigenvalues(k);
    double nearest = 0;
    for (const double s : squared)
      if (std::abs(std::sqrt(std::abs(s)) - exact) < std::abs(nearest - exact))
        nearest = std::sqrt(std::abs(s));
    error[static_cast<std::size_t>(fine)] = nearest / exact - 1;
    verified::below(fmt::format("rigid motions: largest frequency squared over Lame's, {} cells an "
                                "edge",
                                cells),
                    "-", squared.head(6).cwiseAbs().maxCoeff() / (exact * exact), rounding);
  }
  // With lumped masses; consistent ones would require a solve in each explicit step. A third level
  // would take a minute.
  verified::near("frequency of Lame's mode over the exact one, 3 cells an edge", "-", 1 + error[1],
                 1, {0.01, "lumped masses: (k h)^2 / 24, k h = pi / 3 halved by mid-side nodes"});
  verified::above("error with 2 cells an edge over that with 3", "-", error[0] / error[1],
                  {std::pow(1.5, 2), "lumped masses: second order"});
  verified::below("error with 2 cells an edge over that with 3, from above", "-",
                  error[0] / error[1], {std::pow(1.5, 4), "consistent masses: fourth order"});
}

// In static equilibrium under `pressure` on the flat triangles of the top, all sides rollers: the
// largest error of sigma_z at the surface, over 50 kPa.
double surface_error(int cells, const char* name, const std::function<double(double)>& pressure) {
  const TetBox box({2, 2, 2}, {cells, cells, cells});
  GroundParameters p = of_mesh(box, fmt::format("{}_{}", name, cells), {50e6, 0.3, 2000});
  p.integrator = Integrator::bossak, p.alpha = -0.3;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  const auto force = pressure_forces(ground.top(), [&](const Vec3& x) { return pressure(x.x()); });
  for (int w = 0; w < 15; ++w) ground.advance(5, force);
  double error = 0;
  for (const std::int32_t n : ground.own_top()) {
    const double x = ground.top().position[static_cast<std::size_t>(n)].x();
    error = std::max(error, std::abs(ground.top_state(n).sigma_z + pressure(x)));
  }
  return Comm::world().max(error) / 50e3;
}

TEST(Tetrahedra, SurfaceStressIsThePressureOnIt) {
  const auto uniform = [](double) { return 50e3; };
  const auto wave = [](double x) { return 50e3 * (1 + 0.5 * std::cos(pi * x / 2)); };
  for (const int cells : {4, 8})
    verified::below(fmt::format("error of surface stress, uniform pressure, {} cells", cells), "-",
                    surface_error(cells, "uniform", uniform),
                    {4e-8, "constant stress is exact: solver, 1e-8, four times"});
  const double coarse = surface_error(4, "wave", wave), fine = surface_error(8, "wave", wave);
  verified::below("error of surface stress, half a wave of pressure on 8 cells", "-", fine,
                  {0.05, "first order at borders: guards the factor, 0.044"});
  // At borders the faces are on one side of the node: order 1 there.
  verified::near("error with 4 cells over that with 8", "-", coarse / fine, 2.25,
                 {0.35, "first order at borders, 2; second order inside adds to it"});
}

// A pressure pulse travels down a column and leaves through its viscous base.
TEST(Tetrahedra, ViscousBaseAbsorbsAWave) {
  GroundParameters p = of_mesh(TetBox({1, 1, 10}, {1, 1, 30}), "viscous", {50e6, 0.3, 2000});
  p.borders[4].holds = BorderKind::viscous;
  p.base_stiffness = 0;
  p.integrator = Integrator::explicit_;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  std::vector<Vec3> unit(ground.top().nodes(), Vec3::Zero());
  for (const auto& t : ground.top().triangles)
    for (const std::int32_t n : t) unit[static_cast<std::size_t>(n)].z() -= 1e3 / 8 / 3;
  // c_p = 183 m/s: 55 ms down.
  constexpr double dt = 1e-3, pulse = 0.04;
  double most = 0, left = 0;
  for (int w = 0; w < 200; ++w) {
    const double t = (w + 0.5) * dt;
    std::vector<Vec3> force = unit;
    for (Vec3& f : force) f *= t < pulse ? std::pow(std::sin(pi * t / pulse), 2) : 0;
    ground.advance(dt, force);
    const GroundTotals totals = ground.totals();
    left = totals.kinetic + totals.elastic;
    most = std::max(most, left);
  }
  verified::below("remaining energy of a wave after its arrival at the base", "-", left / most,
                  {1e-3, "oscillations of elements behind the pulse: guards their size, 3e-4"});
}

}  // namespace
}  // namespace trackbed::fem::tetrahedra_verify_test
