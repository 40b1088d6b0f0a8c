// Stones that have lost a ball.
#include <stdexcept>

#include "geom/convex/mass.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

std::vector<Sphere> balls_of(const Template& shape) {
  std::vector<Sphere> balls;
  for (const Piece& piece : shape.pieces) {
    if (piece.core.vertices.size() != 1)
      throw std::invalid_argument("only stones of balls can lose one of them");
    balls.push_back({piece.core.vertices[0], piece.radius});
  }
  return balls;
}

// Of the stone about its centre of mass, in its principal axes: the moments of inertia J give the
// integrals of x^2 as (J_y + J_z - J_x)/2.
Integrals integrals_of(const Template& shape) {
  const Vec3 moments = shape.volume * shape.gyration;
  Integrals sums;
  sums.volume = shape.volume;
  sums.second = (Vec3::Constant(moments.sum() / 2) - moments).asDiagonal();
  return sums;
}

}  // namespace

Remainder without_ball(const Template& whole, std::size_t which) {
  constexpr int cells = 128;
  const std::vector<Sphere> balls = balls_of(whole);
  if (balls.size() < 2) throw std::invalid_argument("the only ball of a stone cannot be lost");
  const Integrals part = own_part(balls, which, cells);
  Integrals rest = integrals_of(whole);
  rest.volume -= part.volume, rest.first -= part.first, rest.second -= part.second;
  const Solid solid = solid_of(rest);
  std::vector<Piece> pieces = whole.pieces;
  pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(which));
  const Vec3 lost = part.volume > 0 ? Vec3(part.first / part.volume) : balls[which].centre;
  return {{template_of(pieces, solid, smallest_hole(pieces)), solid.centre, solid.axes},
          part.volume,
          lost};
}

}  // namespace trackbed::geom
