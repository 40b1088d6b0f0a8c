// Distance of two convex cores, or depth of their overlap: the basis of the infrequent work on a
// pair of stones. The work of every sub-step is in features.hpp.
#pragma once

#include <span>
#include <vector>

#include "dem/shape/core.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::dem {

// One core in space; `offset` is added to the corners to refer to a common origin. It holds no
// corners of its own: those it refers to must outlive it.
struct Placed {
  const Core* core;
  std::span<const Vec4> corners;  // m
  Vec3 offset;                    // m
  double radius;                  // m, rounding

  Vec3 corner(std::size_t k) const { return corners[k].vec3() + offset; }
};

// A direction from the first core to the second (unit) with the width of the empty slab across it
// (m, negative: they overlap in this direction). The distance of the cores is no smaller.
struct Slab {
  Vec3 normal = Vec3::UnitX();
  double width = 0;
};

// Width of the slab across this unit vector, m.
double slab_width(const Placed& first, const Placed& second, const Vec3& normal);

// GJK (Gilbert, Johnson, Keerthi 1988, doi:10.1109/56.2083), started from the given direction and
// ended when the slab's width is within `tolerance` m of the distance.
Slab widest_slab(const Placed& first, const Placed& second, const Vec3& start, double tolerance);

// The widest slab over all face normals and crossed edges (separating axis theorem). Exact if the
// cores overlap: minus its width is the smallest displacement that separates them, for cores in one
// plane the smallest within it. Cost: every pair of edges.
Slab separating_axis(const Placed& first, const Placed& second);

// A direction in which overlapping cores can be separated: the second moves by -width along the
// normal. While the first rotates by a small vector a (rad) about the common origin and the second
// is fixed,
//   d normal = swing a,  d width = moment . a (m);  if the second moves by x, d width = normal . x.
struct SeparationDirection {
  Slab slab;
  Vec3 moment;    // m
  Mat3 swing;     // of a face of the second core: zero
  double sine2;   // of crossed edges: sin^2 of the angle between them, as a weight
  Vec3 sharpens;  // d sine2 = sharpens . a; faces: sine2 = 1 and no change
};

// All axes of `separating_axis` with a slab of this width (m) or wider. Replaces the content of
// `directions`.
void separation_directions(const Placed& first, const Placed& second, double least,
                           std::vector<SeparationDirection>& directions);

}  // namespace trackbed::dem
