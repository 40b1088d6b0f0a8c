// Contacts of a piece with several corners with a triangulated surface.
//
// Like a pair of such pieces (features.hpp) it has one energy with each patch of the surface: that
// of the smooth maximum M of the overlaps delta_k = r - d_k of all features, r the piece's
// rounding:
//   corner of the piece and patch: signed distance, the least over the patch's triangles;
//   edge of the piece and sharp edge of the surface: the least over a run of almost straight edges;
//   sharp corner of the surface and piece: signed distance, the least over the piece's triangles.
// Every d_k is continuous, and none depends on how the patch is cut into triangles: edges within a
// smooth patch are no features. Distances are signed so that parts that have penetrated the surface
// are repelled: corners behind a face, edges that have crossed.
//
// Each approach keeps the features that may come within contact before the piece and the surface
// have moved by a margin (`NearFeatures::until` counts the length of their paths). The choice of
// kept features does not affect results.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "dem/shape/mesh.hpp"
#include "dem/shape/separation.hpp"
#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

// In this order within a patch.
enum class FeatureKind : std::uint8_t { corner, edge, sharp_corner };

// Sorted by contact: features that differ in `own` and `part` only are one contact, and the closest
// counts.
struct SurfaceFeature {
  int patch;
  FeatureKind kind;
  std::uint16_t group;  // corner or edge of the piece
  int run;              // of the surface: chain of sharp edges or sharp corner
  int part;             // triangle, sharp edge or sharp corner of the surface
  std::uint16_t own;    // corner, edge or triangle of the piece
  auto operator<=>(const SurfaceFeature&) const = default;
  bool same_contact(const SurfaceFeature& o) const {
    return patch == o.patch && kind == o.kind && group == o.group && run == o.run;
  }
};

// Dropped at each rebuild; a checkpoint has none.
struct NearFeatures {
  std::vector<SurfaceFeature> features;  // ascending
  double until = -1;                     // m, sum of both paths up to which they are valid
};

// One piece near one surface at one moment; all points are relative to the particle's centre.
struct StoneView {
  Placed stone;
  Ball ball;  // around the piece
  const Mesh& mesh;
  const Surface& surface;
  double fraction;  // of the window that has passed
  Vec3 origin;      // m, the particle's centre in the frame of the surface

  Vec3 node(std::int32_t n) const { return node_at(surface, n, fraction) - origin; }
};

// Features that are near now; `triangles`: candidates. `path` m, of both up to now; `pace` m, of
// both in the last sub-step.
void find_features(const StoneView& view, const std::vector<int>& triangles, double path,
                   double pace, NearFeatures& near);
// Contacts with overlap, in the order of patches. Returns a patch if a corner is further behind it
// than the limit `largest_corner_depth`, or -1.
int touch_surface(const StoneView& view, const std::vector<SurfaceFeature>& features,
                  std::vector<MeshContact>& found);

}  // namespace trackbed::dem
