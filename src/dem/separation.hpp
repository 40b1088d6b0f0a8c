// How far two convex cores are apart, or how deep one is in the other: what the rare work on a pair
// of stones is built on. The work of every sub-step is in features.hpp.
#pragma once

#include <span>
#include <vector>

#include "core.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::dem {

// One core in space, corners from a common origin when `offset` is added.
// Holds no corners of its own: what it shows must outlive it.
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

// GJK (Gilbert, Johnson, Keerthi 1988, doi:10.1109/56.2083), started from the direction given and
// ended when the slab's width is within `tolerance` m of the distance.
Slab widest_slab(const Placed& first, const Placed& second, const Vec3& start, double tolerance);

// The widest slab over all face normals and crossed edges (separating axis theorem). Exact where
// the cores overlap: minus its width is the smallest way out, of cores in one plane the smallest
// way within it. Cost: every pair of edges.
Slab separating_axis(const Placed& first, const Placed& second);

// One way to part overlapping cores: the second moves by -width along the normal. While the first
// turns by a small vector a (rad) about the common origin and the second stays,
//   d normal = swing a,  d width = moment . a (m);  if the second moves by x, d width = normal . x.
struct WayOut {
  Slab slab;
  Vec3 moment;    // m
  Mat3 swing;     // of a face of the second core: zero
  double sine2;   // of crossed edges: sin^2 of the angle between them, with which their axis fades
  Vec3 sharpens;  // d sine2 = sharpens . a; faces: sine2 = 1 and no change
};

// All axes of `separating_axis` with a slab of this width (m) or wider.
// Replaces what `ways` held.
void ways_out(const Placed& first, const Placed& second, double least, std::vector<WayOut>& ways);

}  // namespace trackbed::dem
