// From sums over a body to its mass properties.
#pragma once

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

// Integrals of 1, x and x x^T over a body of unit density.
//   volume = int 1 dV, m^3;  first = int x dV, m^4;  second = int x x^T dV, m^5
// Sums, so that a body may be taken apart in any way, with negative parts too. For laminas an area
// stands for the volume, and all units have one m less.
struct Integrals {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};

// The tetrahedron of three points and the origin; negative if they turn clockwise seen from
// outside.
void add_tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, Integrals& sums);

// The volume must be above 0: it divides. Gyration in rising order, axes right-handed.
Solid solid_of(const Integrals& integrals);
// For laminas in the plane y = 0: turns about y alone, so that y stays the polar axis.
Solid lamina_of(const Integrals& integrals);

}  // namespace trackbed::geom
