// Mass properties from integrals over a body.
#pragma once

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

// Integrals of 1, x and x x^T over a body of unit density.
//   volume = int 1 dV, m^3;  first = int x dV, m^4;  second = int x x^T dV, m^5
// Integrals are additive, so a body may be divided in any way, also with negative parts. For
// laminas an area takes the place of the volume, and all units have one m less.
struct Integrals {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};

// The tetrahedron of three points and the origin; negative if they are clockwise seen from outside.
void add_tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, Integrals& sums);

// The part of a ball that is in no other ball, by lines as for unions (union.cpp), `cells` of them
// across the ball.
Integrals own_part(const std::vector<Sphere>& balls, std::size_t which, int cells);

// The volume must be above 0, since it is a divisor. Gyration in rising order, axes right-handed.
Solid solid_of(const Integrals& integrals);
// For laminas in the plane y = 0: rotates about y only, so that y stays the polar axis.
Solid lamina_of(const Integrals& integrals);

}  // namespace trackbed::geom
