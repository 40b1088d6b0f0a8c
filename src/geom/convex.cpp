#include "trackbed/geom/convex.hpp"

#include <algorithm>

namespace trackbed::geom {

Piece ball(const Vec3& centre, double radius) { return {{{centre}, {}, {}}, radius}; }

double bounding_radius(const Template& shape) {
  double bound = 0;
  for (const Piece& piece : shape.pieces)
    for (const Vec3& corner : piece.core.vertices)
      bound = std::max(bound, corner.norm() + piece.radius);
  return bound;
}

}  // namespace trackbed::geom
