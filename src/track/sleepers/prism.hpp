// A convex profile in the x-z plane extruded along y: the shape of a sleeper.
#pragma once

#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::track {

// About its centre of mass; principal axes are x, y, z.
struct Prism {
  std::vector<Eigen::Vector2d> profile;  // m, x and z about the centre of mass, counter-clockwise
                                         // as seen with x to the right and z up
  double length = 0;                     // m, along y
  double volume = 0;                     // m^3
  Vec3 gyration = Vec3::Zero();          // principal inertia over mass about x, y, z, m^2
  double depth = 0;                      // m, centre of mass above the lower face
};

// Box of `width` and `height` whose lower edges along y are cut off at 45 degrees by `bevel`.
Prism bevelled_box(double width, double height, double length, double bevel);

// Closed surface with outward normals: 12 triangles for a box.
Surface surface_of(const Prism& prism);

}  // namespace trackbed::track
