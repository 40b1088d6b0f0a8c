// Parts of a closed mesh between cutting planes.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

// Points with height >= 0 are above.
struct Plane {
  Vec3 normal;    // unit
  double offset;  // m
  double height(const Vec3& p) const { return normal.dot(p) - offset; }
  Plane turned() const { return {-normal, -offset}; }
};

using Corners = std::array<Vec3, 3>;

// The part of a mesh on the upper side of some planes. The sections close it as signed fans of
// triangles, so volumes are exact; a fan may extend beyond its section, so hulls are made without
// it. Kept as triangles: a Boolean operation on meshes would fail for touching or coplanar facets.
struct Part {
  std::vector<Corners> skin, caps;
  std::vector<Plane> planes;
  double volume = 0;          // m^3
  std::vector<Vec3> corners;  // of the hull
  double hull_volume = 0;     // m^3
  double concavity() const { return hull_volume - volume; }
};

Part whole_part(const Mesh& mesh);
// Above and below the plane; `mesh` is the one from which `part` was made.
std::pair<Part, Part> cut(const Part& part, const Plane& plane, const Mesh& mesh);

}  // namespace trackbed::geom
