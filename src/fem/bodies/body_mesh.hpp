// A box of equal hexahedra: numbering of nodes and elements, its surface, and weights on its faces.
// Pure, no state.
#pragma once

#include <vector>

#include "fem/mesh/lattice.hpp"
#include "fem/shape/element.hpp"
#include "trackbed/fem/bodies.hpp"

namespace trackbed::fem {

// Nodes of a body are numbered from `first` on, x fastest, then y, then z.
struct BodyMesh {
  BodyMesh(const Body& body, std::int32_t first);

  Body body;
  std::int32_t first;
  Lattice lattice;        // for numbers and sizes; not for positions
  Hexahedron hexahedron;  // all elements are equal

  std::int32_t nodes() const { return static_cast<std::int32_t>(lattice.node_count()); }
  std::int64_t elements() const { return lattice.element_count(); }
  Vec3 position(std::int32_t node) const;  // m, as built
  std::int32_t node(const Index3& point) const {
    return first + static_cast<std::int32_t>(lattice.node(point));
  }
  std::array<std::int32_t, 8> corners(std::int64_t element) const;
  double mass() const { return body.solid.density * (body.high - body.low).prod(); }
  Vec3 centre() const { return (body.low + body.high) / 2; }
  // kg m^2 about the centre, principal.
  Vec3 inertia() const;
  // Nodes of the face at one end of an axis.
  std::vector<std::int32_t> face(int axis, bool low) const;

  NodeWeights at(Side side, double x, double y) const;  // bilinear; beyond the face: its edge
  // Integration points of a patch, of equal weight.
  static std::vector<std::array<double, 2>> points(const Patch& patch);

  struct Place {
    std::int64_t element;
    Vec3 xi;  // local coordinates, -1 to 1
  };
  // Elements that contain a point of the undeformed body: one, or all that have the face, edge or
  // corner it is on. For points outside the nearest. Ascending.
  std::vector<Place> around(const Vec3& place) const;
};

// Entry of the consistent mass matrix of two nodes for one component, over the mass of the element:
// any rigid motion then has the momentum of the solid.
double mass_fraction(int corner, int other);

// The boundary of a body as triangles with outward normals, without positions, and the node of the
// body for each node of the surface.
Surface surface_of(const BodyMesh& mesh, std::vector<std::int32_t>& node_of);

}  // namespace trackbed::fem
