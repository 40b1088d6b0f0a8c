// An embankment of sections: exact settlement of a column, layers of hexahedra, refinement.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/shape/tetrahedron.hpp"
#include "support/verified.hpp"
#include "unit/fem/embankment_scene.hpp"

namespace trackbed::fem::embankment_verify_test {
namespace {

using par::Comm;

// Lowest frequency with motion along y, Hz: by inverse iteration.
double frequency(const GroundParameters& p) {
  Mesh mesh(Comm::world(), p, Dimension::space, 1);
  const Stiffness stiffness(mesh, matrices_of_elements(mesh));
  const Terms terms(mesh, p, stiffness);
  LinearSystem::Spec spec{std::vector<double>(mesh.solids.solid.size(), 1.0),
                          Nodal(3, mesh.nodes()), terms.held_static, p.tolerance};
  LinearSystem system(mesh, stiffness, spec);
  Nodal u(3, mesh.nodes()), force(3, mesh.nodes());
  for (const std::int32_t n : mesh.own) u[1][n] = 1;
  double squared = 0;
  for (int iteration = 0; iteration < 12; ++iteration) {
    double work = 0, mass = 0, size = 0;  // of force = M u and its solution u
    for (int c = 0; c < 3; ++c)
      for (const std::int32_t n : mesh.own)
        force[c][n] = terms.mass[static_cast<std::size_t>(n)] * u[c][n];
    system.solve(force, u);
    for (int c = 0; c < 3; ++c)
      for (const std::int32_t n : mesh.own) {
        work += force[c][n] * u[c][n];
        mass += terms.mass[static_cast<std::size_t>(n)] * u[c][n] * u[c][n];
        size = std::max(size, std::abs(u[c][n]));
      }
    squared = mesh.comm.sum(work) / mesh.comm.sum(mass);
    size = mesh.comm.max(size);
    for (int c = 0; c < 3; ++c)
      for (const std::int32_t n : mesh.own) u[c][n] /= size;
  }
  return std::sqrt(squared) / (2 * std::numbers::pi);
}

GroundParameters finer(GroundParameters p, std::int64_t times) {
  p.elements_x *= times, p.elements_y *= times;
  for (Layer& layer : p.layers) layer.elements *= times;
  return p;
}

GroundParameters in_hexahedra(GroundParameters p) {
  p.sections.clear(), p.embankment_layers = 0;
  return p;
}

// Upright sides on rollers: w = rho g H^2 (1 + nu) (1 - 2 nu) / (2 E (1 - nu)).
TEST(UprightEmbankment, SettlesAsAColumn) {
  GroundParameters p = upright({-3, 3});
  for (Layer& layer : p.layers) layer.solid = {50e6, 0.3, 2000};
  const double exact = 2000 * gravity * 16 * 1.3 * 0.4 / (2 * 50e6 * 0.7);
  verified::near("settlement under its weight over the exact one", "-",
                 -Rest(p).at({3, 0, 0}).z() / exact, 1,
                 {1e-8, "quadratic displacement is exact: solver, 1e-11 times the condition, 1e3"});
}

// Layers on a fixed base, free sides: bending and shear.
TEST(UprightEmbankment, VibratesAsLayersOfHexahedra) {
  GroundParameters p = upright({-2, 2});
  p.sides = Sides::free, p.elements_y = 4;
  const double hexahedra = frequency(finer(in_hexahedra(p), 4));
  verified::near(
      "first frequency over that of finer hexahedra", "-", frequency(finer(p, 2)) / hexahedra, 1,
      {0.01, "(k h)^2 / 24, quarter wave of 4 m in elements of 0.25 and 0.5 m, and clamp"});
}

// 10 kN on the middle 2 x 2 m of the top: a quarter of each element to its corners, a third of each
// six-node face to its mid-side nodes.
void apply_load(const Mesh& mesh, Nodal& force) {
  const double pressure = 10e3 / 4;
  const auto take = [&](const std::vector<std::int32_t>& nodes, const Vec3& centre, double area) {
    if (std::abs(centre.x() - 3) > 1 || std::abs(centre.y()) > 1) return;
    for (const std::int32_t n : nodes)
      if (mesh.owned[static_cast<std::size_t>(n)] != 0)
        force[2][n] -= pressure * area / static_cast<double>(nodes.size());
  };
  if (mesh.imported) {
    for (const Imported::Face& face : mesh.imported->top) {
      std::vector<std::int32_t> nodes;
      for (const int k : tetrahedron_faces[static_cast<std::size_t>(face.side)])
        nodes.push_back(mesh.corner(static_cast<std::size_t>(face.element), k));
      const auto at = [&](std::size_t k) { return mesh.position(nodes[k]); };
      take({nodes[3], nodes[4], nodes[5]}, (at(0) + at(1) + at(2)) / 3,
           0.5 * (at(1) - at(0)).cross(at(2) - at(0)).z());
    }
    return;
  }
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    if (mesh.lattice.element_index(mesh.element[z])[2] + 1 != mesh.lattice.elements[2]) continue;
    const Vec3 size = mesh.lattice.size_of(mesh.element[z]);
    take({mesh.corner(z, 4), mesh.corner(z, 5), mesh.corner(z, 6), mesh.corner(z, 7)},
         mesh.lattice.centre(mesh.element[z]), size.x() * size.y());
  }
}

TEST(UprightEmbankment, DeflectsAsLayersOfHexahedra) {
  const auto sinks = [](const GroundParameters& p) {
    const Vec3 middle(3, 0, 0);
    return Rest(p, apply_load).at(middle).z() - Rest(p).at(middle).z();
  };
  GroundParameters p = upright({-3, 3});
  p.elements_x = p.elements_y = 6;
  verified::near(
      "settlement below a load over that of finer hexahedra", "-",
      sinks(finer(p, 2)) / sinks(finer(in_hexahedra(p), 4)), 1,
      {0.01, "hexahedra of a quarter of the load's half width a: (h / a)^2 / 8 = 0.8 %"});
}

// A slice between rollers of half an embankment with sides 1:1.5, under its weight. Strains are
// singular at the foot, an angle of w = 214 degrees, as r^(l - 1) with sin(l w) + l sin(w) = 0:
// l = 0.73 (Williams 1952, doi:10.1115/1.4010553). The settlement, like the energy, has the order
// 2 l at last, and 4 as long as the smooth part determines the error. There is no upper bound: with
// these elements the two parts partly cancel (ratios of 5.9 and 21).
TEST(SlopedEmbankment, SettlementConvergesWithTheElements) {
  GroundParameters p = embankment();
  p.x = {0, 1}, p.y = {0, 10}, p.elements_x = 1, p.elements_y = 5;
  std::array<double, 4> sinks{};
  for (std::size_t level = 0; level < 4; ++level) {
    GroundParameters fine = finer(p, std::int64_t{1} << level);
    fine.x[1] = 1.0 / static_cast<double>(fine.elements_x);
    fine.elements_x = 1;
    sinks[level] = -Rest(fine).at({0, 0, 0}).z();
  }
  const double first = std::abs(sinks[1] - sinks[0]), second = std::abs(sinks[2] - sinks[1]);
  const double third = std::abs(sinks[3] - sinks[2]);
  verified::below("change from elements of 1 m to those of half, over the settlement", "-",
                  first / sinks[3],
                  {0.01, "separates: it is small; the orders below determine how it falls"});
  verified::above("changes halving after halving, least ratio", "-",
                  std::min(first / second, second / third), {2.75, "singular foot: 2^(2 * 0.73)"});
}

}  // namespace
}  // namespace trackbed::fem::embankment_verify_test
