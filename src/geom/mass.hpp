// From sums over a body to its mass properties.
#pragma once

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

// Integrals of 1, x and x x^T over a body of unit density.
struct Integrals {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};

Solid solid_of(const Integrals& integrals);
// For laminas in the plane y = 0: turns about y alone, so that y stays the polar axis.
Solid lamina_of(const Integrals& integrals);

}  // namespace trackbed::geom
