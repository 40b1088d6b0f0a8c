// Flat rectangles as surfaces.
#pragma once

#include <string>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::bed {

// Corner and two edges; the normal (towards the stones) is first x second.
Surface plate(const std::string& name, int material, const Vec3& corner, const Vec3& first,
              const Vec3& second);

// Sizes along x and y between the sides: in a plane model y is the thickness, about 0.
struct Footprint {
  Vec3 low, high;  // m, z = 0
  double area() const { return (high.x() - low.x()) * (high.y() - low.y()); }
  // Larger by `margin` on all sides, so that the edges of plates are beyond other plates.
  Footprint grown(double margin) const {
    return {low - Vec3(margin, margin, 0), high + Vec3(margin, margin, 0)};
  }
};

// m: more than a stone may extend beyond a periodic side, since only its home image is in contact
// with surfaces.
inline constexpr double beyond = 0.25;

}  // namespace trackbed::bed
