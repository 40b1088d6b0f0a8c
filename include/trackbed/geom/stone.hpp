// Shapes of stones and their mass properties; pure functions, no time, no ranks.
#pragma once

#include <cstdint>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/geom/convex.hpp"

namespace trackbed::geom {

struct Sphere {
  Vec3 centre;    // m
  double radius;  // m
};

// Mass properties of a solid of unit density.
struct Solid {
  double volume = 0;             // m^3; plane: area in m^2 (times thickness = volume)
  Vec3 centre = Vec3::Zero();    // m
  Vec3 gyration = Vec3::Zero();  // principal moments of inertia over mass, m^2
  Quat axes = Quat::Identity();  // from principal axes to the axes it was given in
};

// Volume of a core swept by a sphere of radius r: volume + area r + bend r^2 + 4/3 pi r^3
// (Steiner).
struct Steiner {
  double volume = 0;  // m^3
  double area = 0;    // m^2; of a flat core, both sides
  double bend = 0;    // m, sum over edges of length times half the angle between the normals
};
Steiner steiner_of(const Convex& core);

// Mass properties and surface of the rounded solid, to rounding errors.
Solid piece_solid(const Piece& piece);
double surface_area(const Piece& piece);  // m^2

// Convex outline of an irregular plane stone: hull (CGAL) of points on a superellipse with random
// angles and radii, drawn from `seed`. Largest extent 1, centred on its area centroid, counter-
// clockwise in (x, z). elongation: smallest width over largest extent, as near as the corners
// allow; angularity 0 (evenly spread corners of an ellipse) to 1.
struct OutlineShape {
  double elongation = 0.7;
  double angularity = 0.3;
  int corners = 12;
};
std::vector<Eigen::Vector2d> outline(const OutlineShape& shape, std::uint64_t seed);

// Area, centroid and gyration of a closed counter-clockwise polygon in (x, z), as a lamina: about
// y the polar one.
Solid polygon_solid(const std::vector<Eigen::Vector2d>& polygon);
// Smallest width over all directions: the smallest slot the plane stone passes through.
double smallest_width(const std::vector<Eigen::Vector2d>& polygon);

// Disks of `radius` inside the convex polygon (x, z; y = 0), touching its border, at most `spacing`
// radii apart along it, so that a stone of disks has the outline's size. One ring: up to a spacing
// of 3 no disk of this radius gets between two of them with less than half a radius of overlap, so
// the inside needs none. Throws std::invalid_argument if none fits.
std::vector<Sphere> pebbles_inside(const std::vector<Eigen::Vector2d>& polygon, double radius,
                                   double spacing);

// Union of overlapping spheres or pieces, by columns along x, each integrated exactly, `cells`
// along the larger of the other two extents. The relative error of volume and gyration falls as
// 1/cells^(3/2).
Solid union_solid(const std::vector<Sphere>& spheres, int cells = 96);
Solid union_solid(const std::vector<Piece>& pieces, int cells = 96);
// The same for disks in the plane y = 0: area, and gyration of the lamina.
Solid union_lamina(const std::vector<Sphere>& disks, int cells = 4096);

}  // namespace trackbed::geom
