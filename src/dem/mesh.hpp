// Where a sphere touches a triangulated surface.
//
// A sphere may be near many triangles; what it feels must not depend on how a face is cut. A
// contact is a local minimum of the distance to the whole surface: a closest point on an edge or
// corner counts only if no triangle that shares the edge or corner is closer, and once if several
// are equally close. Within one smooth patch (triangles joined by edges bent less than
// `smooth_angle`) only the deepest contact is kept, so that a plane cut into triangles, or slightly
// bent by the ground below, acts as one plane; across a sharp concave edge there are two contacts.
#pragma once

#include <array>
#include <vector>

#include "trackbed/core/surface.hpp"

namespace trackbed::dem {

inline constexpr double smooth_angle = 0.35;  // rad (20 degrees)

struct Ball {
  Vec3 centre;
  double radius;
};

struct MeshContact {
  int triangle = -1;
  int patch = -1;
  Vec3 normal = Vec3::Zero();  // unit, from the sphere into the surface
  Vec3 point = Vec3::Zero();   // m, on the surface
  Vec3 weight = Vec3::Zero();  // share of each of the triangle's nodes, sums to 1
  double distance = 0;         // m, centre to point, negative behind a face
};

// Topology of one surface, worked out once from the positions it has then.
class Mesh {
 public:
  explicit Mesh(const Surface& surface);
  int patch(std::size_t triangle) const { return patch_[triangle]; }
  int patches() const { return patches_; }

  // All contacts of the sphere with the candidate triangles (ascending), one per patch, in the
  // order of patches, when the share `s` of the window has passed. Appends to `found`.
  void touch(const Ball& ball, const std::vector<int>& candidates, const Surface& surface, double s,
             std::vector<MeshContact>& found) const;

 private:
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<int> patch_;
  int patches_ = 0;
};

inline Vec3 node_at(const Surface& surface, std::int32_t node, double s) {
  const auto n = static_cast<std::size_t>(node);
  return surface.position[n] + s * surface.motion[n];
}

}  // namespace trackbed::dem
