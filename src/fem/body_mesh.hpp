// A box of equal hexahedra: numbers of nodes and elements, its surface, and weights on its faces.
// Pure, no state.
#pragma once

#include <vector>

#include "element.hpp"
#include "lattice.hpp"
#include "trackbed/fem/bodies.hpp"

namespace trackbed::fem {

// Nodes of a body are numbered from `first` on, x fastest, then y, then z.
struct BodyMesh {
  BodyMesh(const Body& body, std::int32_t first);

  Body body;
  std::int32_t first;
  Lattice lattice;        // of numbers and sizes; its own positions are those of a ground
  Hexahedron hexahedron;  // all elements are alike

  std::int32_t nodes() const { return static_cast<std::int32_t>(lattice.node_count()); }
  std::int64_t elements() const { return lattice.zone_count(); }
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
  // Of a patch, of equal weight.
  static std::vector<std::array<double, 2>> points(const Patch& patch);

  struct Place {
    std::int64_t element;
    Vec3 xi;  // -1 to 1 in it
  };
  // Of the elements around a point as built: one, or those that share the face, edge or corner it
  // lies on. Beyond the body the nearest. Ascending.
  std::vector<Place> around(const Vec3& place) const;
};

// Consistent mass of a node pair of one component over that of the element: rigid motions of any
// kind then have the momentum of the solid.
double mass_share(int corner, int other);

// The outside of a body as triangles with normals outwards, without positions, and the node of the
// body that each of its nodes is.
Surface surface_of(const BodyMesh& mesh, std::vector<std::int32_t>& node_of);

}  // namespace trackbed::fem
