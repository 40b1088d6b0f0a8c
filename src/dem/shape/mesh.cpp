// Closest points of triangles and the choice among them (mesh.hpp). Every candidate is tried in
// every sub-step: they are few, and the closest may change each time.
#include "dem/shape/mesh.hpp"

#include <algorithm>
#include <cmath>

#include "dem/shape/features.hpp"

namespace trackbed::dem {

// Triangles that share an edge are equally far from a point beside it, to rounding: `equal`, m^2.
// The choice is by distance, then faces before edges, then by the largest height over the triangle;
// only among coplanar ones does the order of triangles decide.
bool Closest::replaces(const Closest& old, double equal) const {
  if (squared < old.squared - equal) return true;
  if (squared > old.squared + equal) return false;
  if ((part == 7) != (old.part == 7)) return part == 7;
  constexpr double clearly = 1 + 1e-9;  // coplanar triangles: the first
  return std::abs(height) > clearly * std::abs(old.height);
}

// The height is measured from the plane, the distance from the triangle. The two agree inside the
// face only. Computed on plain numbers: Eigen's cross products go through memory in halves, and the
// resulting processor stalls take four times as long as all the rest.
Closest Mesh::closest(const Vec3& p, int triangle, const Surface& surface, double s,
                      const Vec3& origin, double reach) const {
  const auto& nodes = triangles_[static_cast<std::size_t>(triangle)];
  const auto node = [&](std::size_t k) { return triple(node_at(surface, nodes[k], s) - origin); };
  const Triple<double> a = node(0), b = node(1), c = node(2);
  const Triple<double> ab = b - a, ac = c - a, ap = triple(p) - a, area = cross(ab, ac);
  Closest result;
  MeshContact& hit = result.contact;
  hit.triangle = triangle, hit.patch = patch(triangle);
  const double square = dot(area, area);
  // Most triangles of a list are out of reach: they need no root and no division. The margin is
  // above all rounding, so that a contact is never rejected.
  constexpr double margin = 1 + 1e-9;
  if (const double above = dot(area, ap); above * above > margin * reach * reach * square) {
    hit.distance = std::numeric_limits<double>::infinity();
    return result;
  }
  const double length = square > 0 ? root(square) : 1;
  // Divided, so that the normal of a level triangle is exactly vertical.
  const Triple<double> out{area.x / length, area.y / length, area.z / length};
  result.height = dot(out, ap);
  result.out = vec3(out), hit.normal = -result.out;
  // Weights of the projection onto the plane times the square of twice the triangle's area; nearly
  // always inside. A triangle without area has no inside.
  const double v = dot(area, cross(ap, ac)), w = dot(area, cross(ab, ap));
  if (v > 0 && w > 0 && v + w < square)
    hit.weight = {1 - (v + w) / square, v / square, w / square};
  else
    hit.weight = closest_weights(p, vec3(a), vec3(b), vec3(c));
  for (int k = 0; k < 3; ++k) result.part |= hit.weight[k] > 0 ? 1u << k : 0u;
  if (result.part == 7) {
    // Projection and normal of the plane, which are bitwise identical for all triangles if it is
    // level.
    hit.distance = result.height, hit.point = vec3(triple(p) - result.height * out);
  } else {
    hit.point = vec3(hit.weight[0] * a + hit.weight[1] * b + hit.weight[2] * c);
    hit.distance = (hit.point - p).norm();
    if (hit.distance > 0) hit.normal = (hit.point - p) / hit.distance;
  }
  result.squared = hit.distance * hit.distance;
  return result;
}

double Mesh::distance(const Ball& ball, const std::vector<int>& candidates, const Surface& surface,
                      double s) const {
  double least = std::numeric_limits<double>::infinity();
  for (const int t : candidates)
    least = std::min(least,
                     std::abs(closest(ball.centre, t, surface, s, Vec3::Zero()).contact.distance));
  return least;
}

// The side of the surface on which a point beside an edge or a corner of the closest triangle is.
bool Mesh::determine_side(Closest& c, const Vec3& p, const Surface& surface, double s,
                          const Vec3& origin) const {
  MeshContact& hit = c.contact;
  const auto t = static_cast<std::size_t>(hit.triangle);
  if (c.part == 7) return true;
  const Border border = border_[t][c.part];
  if (border != Border::crease) {
    // The side is that relative to the triangle that faces the point.
    const bool behind = border == Border::inner && c.height < 0;
    if (behind) hit.distance = -hit.distance, hit.normal = -hit.normal;
    return border == Border::inner;
  }
  // A concave edge: the patch is continued as a plane. Weights of the projection outside of the
  // triangle are beyond 0 and 1; they still sum to 1 and still give the projected point, so force
  // and moment on the nodes stay exact.
  hit.distance = c.height, hit.normal = -c.out, hit.point = p - c.height * c.out;
  const auto& nodes = triangles_[t];
  const Vec3 a = node_at(surface, nodes[0], s) - origin;
  const Vec3 ab = node_at(surface, nodes[1], s) - origin - a;
  const Vec3 ac = node_at(surface, nodes[2], s) - origin - a, ap = hit.point - a;
  const Vec3 area = ab.cross(ac);
  const double over = 1 / area.squaredNorm();
  const double v = over * area.dot(ap.cross(ac)), w = over * area.dot(ab.cross(ap));
  hit.weight = {1 - v - w, v, w};
  return true;
}

// Positions are absolute here; those of stones are relative to their own centre
// (stone_surface.hpp).
void Mesh::touch(const Ball& ball, const std::vector<int>& candidates, const Surface& surface,
                 double s, std::vector<MeshContact>& found) const {
  const auto& [centre, radius] = ball;
  const Vec3 origin = Vec3::Zero();
  thread_local std::vector<Closest> near;  // keeps its capacity: no allocation per step
  near.clear();
  const double equal = 1e-12 * radius * radius;  // distances to the same edge differ by rounding
  for (const int t : candidates) {
    const Closest c = closest(centre, t, surface, s, origin, radius);
    // Up to a radius behind a face as well: the ball is repelled, with an overlap of up to twice
    // its radius.
    if (std::abs(c.contact.distance) >= radius) continue;
    const auto same = std::find_if(near.begin(), near.end(), [&](const Closest& other) {
      return other.contact.patch == c.contact.patch;
    });
    if (same == near.end())
      near.push_back(c);
    else if (c.replaces(*same, equal))
      *same = c;
  }
  std::sort(near.begin(), near.end(),
            [](const Closest& a, const Closest& b) { return a.contact.patch < b.contact.patch; });
  for (Closest& c : near) {
    determine_side(c, centre, surface, s, origin);
    found.push_back(c.contact);
  }
}

}  // namespace trackbed::dem
