// Cores moved, scaled and rounded; templates of pieces.
//
// A template is what many stones have in common: unit size, centre of mass at the origin, principal
// axes along x, y, z. A stone of scale s has the volume s^3 V and the inertia m s^2 gyration.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using std::numbers::pi;

// Positive root of volume x^3 + area r x^2 + bend r^2 x + ball = volume, whose left side grows with
// x. The core is scaled by x, which scales the terms of Steiner's formula by x^3, x^2 and x; the
// required value is the volume before rounding. At x = 1 the sum is above it, at 0 below.
double shrinkage(const Steiner& s, double r) {
  const double ball = 4 * pi / 3 * r * r * r;
  if (!(ball < s.volume))
    throw std::invalid_argument(
        "the rounding radius is too large: a ball of this radius is larger than the stone");
  double low = 0, high = 1;
  constexpr int halvings = 60;  // to the last bit
  for (int k = 0; k < halvings; ++k) {
    const double x = (low + high) / 2;
    const double volume = ((s.volume * x + s.area * r) * x + s.bend * r * r) * x + ball;
    (volume < s.volume ? low : high) = x;
  }
  return (low + high) / 2;
}

}  // namespace

// Edges hold indices only and are unchanged.
Convex moved(Convex core, const Quat& turn, const Vec3& shift) {
  for (Vec3& corner : core.vertices) corner = turn * corner + shift;
  for (Face& face : core.faces) {
    face.normal = turn * face.normal;
    face.offset += face.normal.dot(shift);
  }
  return core;
}

Convex scaled(Convex core, double factor) {
  for (Vec3& corner : core.vertices) corner *= factor;
  for (Face& face : core.faces) face.offset *= factor;
  return core;
}

// About the centroid, which is therefore fixed; the centre of the rounded solid differs from it
// only by the asymmetry of the stone.
Piece rounded(const Convex& hull, double radius) {
  if (radius == 0) return {hull, 0};
  const double factor = shrinkage(steiner_of(hull), radius);
  const Vec3 centre = piece_solid({hull, 0}).centre;
  const Convex core = scaled(moved(hull, Quat::Identity(), -centre), factor);
  return {moved(core, Quat::Identity(), centre), radius};
}

// From the axes of the input to the principal ones: x' = axes^T (x - centre).
Template template_of(const std::vector<Piece>& pieces, const Solid& solid, double sieve) {
  Template shape;
  const Quat back = solid.axes.conjugate();
  for (const Piece& piece : pieces)
    shape.pieces.push_back({moved(piece.core, back, back * -solid.centre), piece.radius});
  shape.volume = solid.volume;
  shape.gyration = solid.gyration;
  shape.sieve = sieve;
  return shape;
}

Template template_of(const std::vector<Piece>& pieces) {
  constexpr int cells = 192;
  const Solid solid = pieces.size() == 1 ? piece_solid(pieces[0]) : union_solid(pieces, cells);
  return template_of(pieces, solid, smallest_hole(pieces));
}

// Surface of the ball of this volume: (36 pi V^2)^(1/3).
double sphericity(double volume, double area) {
  return std::cbrt(pi * 36 * volume * volume) / area;
}

}  // namespace trackbed::geom
