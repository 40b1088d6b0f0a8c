// Embankments of sections, and their static equilibrium.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "fem/boundary/terms.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/solver/linear_system.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// 1 m of capping and 1 m of fill, sides 1:1.5, on 2 m of soil; 6 x 10 x 8 m.
inline GroundParameters embankment() {
  GroundParameters p;
  p.x = {0, 6}, p.y = {-10, 10};
  p.elements_x = 3, p.elements_y = 10;
  p.layers = {{.name = "capping", .thickness = 1, .solid = {120e6, 0.3, 2000}, .elements = 1},
              {.name = "fill", .thickness = 1, .solid = {80e6, 0.3, 1900}, .elements = 1},
              {.name = "soil", .thickness = 2, .solid = {40e6, 0.35, 1800}, .elements = 2}};
  p.sections = {{.x = 0, .crest = 3}};
  p.embankment_layers = 2;
  p.base = Base::fixed;
  p.tolerance = 1e-11;
  return p;
}

// The same as a box: crest and foot are at the ends of the ground.
inline GroundParameters upright(const std::vector<double>& y) {
  GroundParameters p = embankment();
  p.y = y;
  p.sections = {{.x = 0, .crest = y[1], .slope = 0}};
  return p;
}

// Elements of layers, for operators without a Ground.
inline std::vector<ElementMatrices> matrices_of_elements(const Mesh& mesh) {
  std::vector<ElementMatrices> all;
  if (mesh.imported) return all;
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
    all.push_back(element_matrices(mesh.solids.size[s], mesh.solids.solid[s], Dimension::space,
                                   PlaneState::strain));
  return all;
}

// A mesh, and its static displacements under its weight and `force` (N, by node). Collective.
struct Rest {
  using Force = std::function<void(const Mesh&, Nodal&)>;
  explicit Rest(const GroundParameters& p, const Force& add = {})
      : mesh(par::Comm::world(), p, Dimension::space, 1), u(3, mesh.nodes()) {
    const Stiffness stiffness(mesh, matrices_of_elements(mesh));
    const Terms terms(mesh, p, stiffness);
    LinearSystem::Spec spec{std::vector<double>(mesh.solids.solid.size(), 1.0),
                            Nodal(3, mesh.nodes()), terms.held_static, p.tolerance};
    for (const Spring& spring : terms.springs)
      for (int c = 0; c < 3; ++c) spec.diagonal[c][spring.node] += spring.stiffness;
    Nodal force(3, mesh.nodes());
    for (const std::int32_t n : mesh.own) force[2][n] -= terms.weight(static_cast<std::size_t>(n));
    if (add) add(mesh, force);
    LinearSystem(mesh, stiffness, spec).solve(force, u);
  }
  // Displacement of the node nearest to a place, m; the same on every rank.
  Vec3 at(const Vec3& place) const {
    double least = 1e300;
    std::int32_t nearest = -1;
    for (const std::int32_t n : mesh.own)
      if (const double far = (mesh.position(n) - place).norm(); far < least)
        least = far, nearest = n;
    const double all = -mesh.comm.max(-least);
    std::array<double, 3> found;
    for (int c = 0; c < 3; ++c)
      found[static_cast<std::size_t>(c)] = mesh.comm.max(least == all ? u[c][nearest] : -1e300);
    return {found[0], found[1], found[2]};
  }

  Mesh mesh;
  Nodal u;  // m
};

}  // namespace trackbed::fem
