// Parts of a mesh by clipping its triangles.
//
// A part is not stored as a closed mesh: its skin consists of pieces of the mesh's triangles, its
// caps of signed fans that represent the sections. For the volume signs suffice, whatever the shape
// of the section, holes included. The corners of the hull are those of the skin and the points
// inside the mesh where cutting planes intersect.
#include "geom/mesh/part.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geom/convex/hull.hpp"
#include "geom/convex/mass.hpp"

namespace trackbed::geom {

namespace {

// Winding number of the mesh around a point: 1 inside, 0 outside (solid angles after van Oosterom,
// Strackee 1983, doi:10.1109/TBME.1983.325207). Cost: one pass over the triangles. Used only for
// corners of three planes, of which there are few. On the surface itself the result depends on
// rounding, and the hull may lose such a corner (1e-5 of a volume was observed).
double winding(const Mesh& mesh, const Vec3& p) {
  double angle = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 a = mesh.vertices[static_cast<std::size_t>(i)] - p,
               b = mesh.vertices[static_cast<std::size_t>(j)] - p,
               c = mesh.vertices[static_cast<std::size_t>(k)] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

// Intersections of three planes of the part inside the mesh: corners that are on no triangle of it.
// Without them the hull of an inner part would lack its corners in the middle of the body, and its
// volume would be too small. Triples of planes: a part has as many planes as cuts made it.
void add_inner_corners(const Mesh& mesh, Part& part) {
  // Of unit normals: the volume they span.
  constexpr double parallel = 1e-6;
  constexpr double tolerance = 1e-9;  // of the extent, at the intersecting planes
  const double near = tolerance * extent_of(mesh.vertices);
  const auto& planes = part.planes;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = i + 1; j < planes.size(); ++j)
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        Mat3 normals;
        normals << planes[i].normal.transpose(), planes[j].normal.transpose(),
            planes[k].normal.transpose();
        if (std::abs(normals.determinant()) < parallel) continue;
        const Vec3 p =
            normals.inverse() * Vec3(planes[i].offset, planes[j].offset, planes[k].offset);
        const bool above = std::all_of(planes.begin(), planes.end(),
                                       [&](const Plane& q) { return q.height(p) > -near; });
        if (above && winding(mesh, p) > 0.5) part.corners.push_back(p);
      }
}

bool before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// Volume about a point of the skin, to avoid cancellation. Corners: equal ones are removed before
// the hull, those inside it after, so that later cuts handle fewer.
void measure(const Mesh& mesh, Part& part) {
  part.corners.clear();
  part.volume = part.hull_volume = 0;
  if (part.skin.empty()) return;
  const Vec3 origin = part.skin[0][0];
  Integrals sums;
  for (const auto* side : {&part.skin, &part.caps})
    for (const auto& [a, b, c] : *side) add_tetrahedron(a - origin, b - origin, c - origin, sums);
  part.volume = sums.volume;
  for (const Corners& triangle : part.skin)
    part.corners.insert(part.corners.end(), triangle.begin(), triangle.end());
  add_inner_corners(mesh, part);
  std::sort(part.corners.begin(), part.corners.end(), before);
  part.corners.erase(std::unique(part.corners.begin(), part.corners.end()), part.corners.end());
  std::vector<Vec3> corners;
  std::vector<bool> kept(part.corners.size());
  Integrals hull;
  for (const auto& [i, j, k] : hull_triangles(part.corners)) {
    const auto at = [&](int v) -> Vec3 {
      return part.corners[static_cast<std::size_t>(v)] - origin;
    };
    add_tetrahedron(at(i), at(j), at(k), hull);
    for (const int v : {i, j, k}) kept[static_cast<std::size_t>(v)] = true;
  }
  for (std::size_t k = 0; k < kept.size(); ++k)
    if (kept[k]) corners.push_back(part.corners[k]);
  part.corners = corners;
  part.hull_volume = hull.volume;
}

using Segment = std::array<Vec3, 2>;

// Intersection of the plane and the edge, by the same operations for either direction of the edge:
// both adjacent triangles must obtain bitwise identical points. Copies a rounding error apart would
// be on different sides of a later plane through them, and its section would not close.
Vec3 crossing(const Vec3& a, double ha, const Vec3& b, double hb) {
  return before(a, b) ? Vec3(a + ha / (ha - hb) * (b - a)) : Vec3(b + hb / (hb - ha) * (a - b));
}

// The parts of the triangle with height >= 0 (Sutherland, Hodgman 1974, doi:10.1145/360767.360802)
// and below, and the border of the upper part along the plane. Both sides use the same computed
// points, so that no gap opens between them.
void split(const Corners& triangle, const Plane& plane, std::vector<Corners>& above,
           std::vector<Corners>& below, std::vector<Segment>& section) {
  std::vector<Vec3> up, down;
  Segment border;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = triangle[k], &b = triangle[(k + 1) % 3];
    const double ha = plane.height(a), hb = plane.height(b);
    (ha >= 0 ? up : down).push_back(a);
    if ((ha >= 0) == (hb >= 0)) continue;
    const Vec3 p = crossing(a, ha, b, hb);
    up.push_back(p);
    down.push_back(p);
    border[ha >= 0 ? 0 : 1] = p;  // leaves the upper side at 0, comes back at 1
  }
  if (!up.empty() && !down.empty()) section.push_back(border);
  for (std::size_t k = 1; k + 1 < up.size(); ++k) above.push_back({up[0], up[k], up[k + 1]});
  for (std::size_t k = 1; k + 1 < down.size(); ++k)
    below.push_back({down[0], down[k], down[k + 1]});
}

}  // namespace

Part whole_part(const Mesh& mesh) {
  Part part;
  for (const auto& [i, j, k] : mesh.triangles)
    part.skin.push_back({mesh.vertices[static_cast<std::size_t>(i)],
                         mesh.vertices[static_cast<std::size_t>(j)],
                         mesh.vertices[static_cast<std::size_t>(k)]});
  measure(mesh, part);
  return part;
}

// The centre of the fan is the mean of the section's points. It may be outside the section:
// triangles of opposite orientation then subtract the excess. Caps of earlier cuts are split too,
// and their borders join the section.
std::pair<Part, Part> cut(const Part& part, const Plane& plane, const Mesh& mesh) {
  Part above, below;
  std::vector<Segment> section;
  for (const Corners& t : part.skin) split(t, plane, above.skin, below.skin, section);
  for (const Corners& t : part.caps) split(t, plane, above.caps, below.caps, section);
  Vec3 middle = Vec3::Zero();
  for (const auto& [p, q] : section) middle += (p + q) / (2 * static_cast<double>(section.size()));
  for (const auto& [p, q] : section) {
    above.caps.push_back({middle, q, p});
    below.caps.push_back({middle, p, q});
  }
  above.planes = below.planes = part.planes;
  above.planes.push_back(plane);
  below.planes.push_back(plane.turned());
  measure(mesh, above);
  measure(mesh, below);
  return {above, below};
}

}  // namespace trackbed::geom
