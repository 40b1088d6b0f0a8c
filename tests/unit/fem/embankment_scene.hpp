// Embankments of sections, and how they rest.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "fem/linear_system.hpp"
#include "fem/stiffness.hpp"
#include "fem/terms.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// 1 m of capping and 1 m of fill, sides 1:1.5, on 2 m of soil; 6 x 10 x 8 m.
inline GroundParameters embankment() {
  GroundParameters p;
  p.x = {0, 6}, p.y = {-10, 10};
  p.zones_x = 3, p.zones_y = 10;
  p.layers = {{.name = "capping", .thickness = 1, .solid = {120e6, 0.3, 2000}, .zones = 1},
              {.name = "fill", .thickness = 1, .solid = {80e6, 0.3, 1900}, .zones = 1},
              {.name = "soil", .thickness = 2, .solid = {40e6, 0.35, 1800}, .zones = 2}};
  p.sections = {{.x = 0, .crest = 3}};
  p.embankment_layers = 2;
  p.base = Base::fixed;
  p.tolerance = 1e-11;
  return p;
}

// The same as a box: crest and foot are where the ground ends.
inline GroundParameters upright(const std::vector<double>& y) {
  GroundParameters p = embankment();
  p.y = y;
  p.sections = {{.x = 0, .crest = y[1], .slope = 0}};
  return p;
}

// Elements of layers, for operators without a Ground.
inline std::vector<ZoneElement> elements_of_zones(const Mesh& mesh) {
  std::vector<ZoneElement> all;
  if (mesh.imported) return all;
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
    all.push_back(zone_element(mesh.solids.size[s], mesh.solids.solid[s], Dimension::space,
                               PlaneState::strain));
  return all;
}

// A mesh, and its displacements at rest under its weight and `force` (N, by node). Collective.
struct Rest {
  using Force = std::function<void(const Mesh&, Nodal&)>;
  explicit Rest(const GroundParameters& p, const Force& add = {})
      : mesh(par::Comm::world(), p, Dimension::space, 1), u(3, mesh.nodes()) {
    const Stiffness stiffness(mesh, elements_of_zones(mesh));
    const Terms terms(mesh, p, stiffness);
    LinearSystem::Spec spec{std::vector<double>(mesh.solids.solid.size(), 1.0),
                            Nodal(3, mesh.nodes()), terms.held_at_rest, p.tolerance};
    for (const Spring& spring : terms.springs)
      for (int c = 0; c < 3; ++c) spec.diagonal[c][spring.node] += spring.stiffness;
    Nodal force(3, mesh.nodes());
    for (const std::int32_t n : mesh.own) force[2][n] -= terms.weight(static_cast<std::size_t>(n));
    if (add) add(mesh, force);
    LinearSystem(mesh, stiffness, spec).solve(force, u);
  }
  // m, of the node nearest to a place; the same on every rank.
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
