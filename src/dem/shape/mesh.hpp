// Contact points of a sphere, or of the corner of a stone, with a triangulated surface.
//
// The force on a body must not depend on how a face is cut. A **patch** is a set of triangles
// joined by edges bent less than `smooth_angle` or bent away from the stones (convex); two sides of
// a sharp concave edge are different patches. A point has one contact with a patch, the closest
// point of it: its signed distance is continuous, however the patch is cut, and a body that rolls
// over the edge of a sleeper keeps its contact and its history. In a concave edge it has two.
//
// Beyond a concave edge a patch is continued as the plane of its border, so that it acts all along
// it and also on bodies that have penetrated the other patch. Beyond an open edge the surface ends.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "trackbed/core/surface.hpp"

namespace trackbed::dem {

inline constexpr double smooth_angle = 0.35;  // rad (20 degrees)

struct Ball {
  Vec3 centre;
  double radius;
};

// Contact point and the distribution of its force to nodes.
struct MeshContact {
  int triangle = -1;
  int patch = -1;
  Vec3 normal = Vec3::Zero();  // unit, into the surface
  Vec3 point = Vec3::Zero();   // m, on the surface
  Vec3 weight = Vec3::Zero();  // weight of each of the triangle's nodes, sums to 1
  double distance = 0;         // m, to the point, negative behind a face
};

// The closest point of one triangle; the sign of the distance is not yet determined.
struct Closest {
  MeshContact contact;
  double squared = 1e300;  // m^2, distance^2
  double height = 0;       // m, over the triangle's plane
  Vec3 out = Vec3::Zero();
  unsigned part = 0;  // bit k: node k has a non-zero weight; 7: inside the face

  // Of two triangles that share the closest part, the one that faces the point determines the side.
  bool replaces(const Closest& old, double equal) const;
};

// An edge that can be in contact with edges of a stone: convex and sharp, or open.
struct SharpEdge {
  std::array<std::int32_t, 2> nodes;
  std::array<int, 2> triangles;  // ascending; of an open edge the second is -1
  int chain;                     // sharp edges that continue almost straight have one number
};
// A node where sharp edges end or bend.
struct SharpCorner {
  std::int32_t node;
  int triangle;
};

// Topology of one surface, determined once from its initial positions. Bends are not measured
// again: a surface loaded by stones bends by far less than `smooth_angle`.
class Mesh {
 public:
  explicit Mesh(const Surface& surface);
  int patch(int triangle) const { return patch_[static_cast<std::size_t>(triangle)]; }
  int patches() const { return patches_; }
  const SharpEdge& edge(int k) const { return edges_[static_cast<std::size_t>(k)]; }
  const SharpCorner& corner(int k) const { return corners_[static_cast<std::size_t>(k)]; }
  // Numbers of the sharp edges and corners that belong to a triangle; each belongs to one.
  std::span<const int> edges_of(int triangle) const { return edges_at_.of(triangle); }
  std::span<const int> corners_of(int triangle) const { return corners_at_.of(triangle); }

  // All contacts of the sphere with the candidate triangles (ascending), one per patch, in the
  // order of patches, at the fraction `s` of the window. Appends to `found`.
  void touch(const Ball& ball, const std::vector<int>& candidates, const Surface& surface, double s,
             std::vector<MeshContact>& found) const;

  // Distance of the centre of the ball from the nearest candidate, m, whichever side it is on.
  double distance(const Ball& ball, const std::vector<int>& candidates, const Surface& surface,
                  double s) const;

  // Closest point of a triangle to p; p and the point are relative to `origin`. If the triangle's
  // plane is farther away than `reach` (m), only the distance is set, to infinity.
  Closest closest(const Vec3& p, int triangle, const Surface& surface, double s, const Vec3& origin,
                  double reach = std::numeric_limits<double>::infinity()) const;
  // Determines sign and normal of the closest point of a patch. Returns false where the surface
  // ends: there the distance has no sign.
  bool determine_side(Closest& c, const Vec3& p, const Surface& surface, double s,
                      const Vec3& origin) const;

 private:
  friend class MeshBuilder;
  // What is beyond a side or a node of a triangle. Ascending: the more open one applies at a node.
  enum class Border : std::uint8_t { inner, crease, open };
  struct Numbers {  // lists of numbers, one for each triangle
    std::vector<int> begin, numbers;
    std::span<const int> of(int triangle) const {
      const auto t = static_cast<std::size_t>(triangle);
      return std::span(numbers).subspan(static_cast<std::size_t>(begin[t]),
                                        static_cast<std::size_t>(begin[t + 1] - begin[t]));
    }
  };

  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<int> patch_;
  std::vector<std::array<Border, 8>> border_;  // by Closest::part
  std::vector<SharpEdge> edges_;
  std::vector<SharpCorner> corners_;
  Numbers edges_at_, corners_at_;
  int patches_ = 0;
};

inline Vec3 node_at(const Surface& surface, std::int32_t node, double s) {
  const auto n = static_cast<std::size_t>(node);
  return surface.position[n] + s * surface.motion[n];
}

}  // namespace trackbed::dem
