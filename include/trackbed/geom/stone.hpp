// Shapes of stones and their mass properties; pure functions, no time, no ranks.
#pragma once

#include <cstdint>
#include <optional>
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
  Quat axes = Quat::Identity();  // from principal axes to the axes of the input
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

// The piece with the volume of `hull` and this radius of rounding: the hull is shrunk towards its
// centroid, with all its corners and faces, before it is swept. So the mass is kept, faces stay
// where they are to first order, and corners recede. Throws std::invalid_argument if a ball of this
// radius is larger than the hull.
Piece rounded(const Convex& hull, double radius);
// First rotated, then moved.
Convex moved(Convex core, const Quat& turn, const Vec3& shift);
Convex scaled(Convex core, double factor);  // about the origin
// The core cut into `parts` convex ones of equal volume, each time across the longest principal
// axis. Swept by the same ball, they fill exactly the volume of the swept core. Throws
// std::invalid_argument if the core cannot be cut.
std::vector<Convex> sliced(const Convex& core, int parts);

// m, the largest normal . x; of a stone with its rounding. `normal`: unit length.
double support_of(const Convex& core, const Vec3& normal);
double support_of(const Template& stone, const Vec3& normal);
// The part of a polyhedron with normal . x <= offset (m), and the area in m^2 of its section.
Convex core_below(const Convex& core, const Vec3& normal, double offset);
double section_area(const Convex& core, const Vec3& normal, double offset);

// Pieces about the solid's centre in its principal axes.
Template template_of(const std::vector<Piece>& pieces, const Solid& solid, double sieve);
// The solid is that of the pieces, exact for one, by columns for several (see `union_solid`); the
// sieve size is the smallest square hole that the stone passes.
Template template_of(const std::vector<Piece>& pieces);

// The box around a stone as measured with callipers: thickness S, the smallest distance of two
// parallel planes that touch the stone (thickness E of EN 933-4); width I, the smallest such
// distance at right angles to it; length L at right angles to both. S <= I <= L, each at most the
// stone's greatest extent; S <= smallest square hole <= I. Exact to rounding for convex pieces of
// one radius and their hull, to 1e-6 of the size for spheres of different radii.
struct Callipers {
  double length = 0, width = 0, thickness = 0;  // m; L, I, S
  Mat3 axes = Mat3::Identity();                 // unit columns along L, I and S, right-handed
};
Callipers callipers_of(const Convex& core);
Callipers callipers_of(const std::vector<Piece>& pieces);
// m, the greatest distance of two points, equal to that of two touching parallel planes (EN 933-4).
double greatest_extent(const std::vector<Piece>& pieces);

// Irregular convex stone with triangular faces, drawn from `seed`: a worn polyhedron of four to six
// main corners. Its proportions by callipers, rounding included, are exact to 1e-9. Length L = 1
// along x, width along y, thickness along z, centre of mass at the origin. `rounding`: radius over
// the diameter of the ball of the stone's volume. With a spread of 0.23 the defaults reproduce the
// mean and the spread of sphericity and of volume over bounding box of ten scanned ballast stones
// (HRSBallast, CC0). Throws std::invalid_argument if no stone of this kind has so many corners or
// these proportions.
struct StoneShape {
  double elongation = 0.85;  // width over length, I/L
  double flatness = 0.65;    // thickness over width, S/I
  double angularity = 1;     // 0: corners evenly spread over an ellipsoid; to 1
  int vertices = 24;         // exactly; 6 to 200
  double spread = 0;         // both proportions are drawn from +- this around the wanted ones
};
// The proportions of the stone of this seed: those of `shape` without a spread.
StoneShape proportions_of(const StoneShape& shape, std::uint64_t seed);
Piece rounded_stone(const StoneShape& shape, double rounding, std::uint64_t seed);
Convex stone(const StoneShape& shape, std::uint64_t seed);  // the same without rounding

// Smallest slot of the plane y = 0 that disks pass, and smallest square hole that spheres pass. A
// rounded piece passes where balls at its corners pass. To 1e-6 of the size, in the nearest minimum
// of the best directions of a raster 4.5 degrees apart.
double smallest_slot(const std::vector<Sphere>& disks);
double smallest_hole(const std::vector<Sphere>& spheres);
double smallest_hole(const std::vector<Piece>& pieces);

// Surface of the ball of this volume over the area (Wadell 1932, doi:10.1086/623964).
double sphericity(double volume, double area);

// Convex outline of an irregular plane stone: hull (CGAL) of points on a superellipse with random
// angles and radii, drawn from `seed`. Largest extent 1, centred on its area centroid,
// counter-clockwise in (x, z). elongation: smallest width over largest extent, as close as the
// corners allow; angularity 0 (evenly spread corners of an ellipse) to 1.
struct OutlineShape {
  double elongation = 0.7;
  double angularity = 0.3;
  int corners = 12;
};
std::vector<Eigen::Vector2d> outline(const OutlineShape& shape, std::uint64_t seed);

// Area, centroid and gyration of a closed counter-clockwise polygon in (x, z), as a lamina: about
// y the polar one.
Solid polygon_solid(const std::vector<Eigen::Vector2d>& polygon);
// Smallest width over all directions: the smallest slot that the plane stone passes.
double smallest_width(const std::vector<Eigen::Vector2d>& polygon);

// Disks of `radius` inside the convex polygon (x, z; y = 0), touching its border, at most `spacing`
// radii apart along it, so that a stone of disks has the size of the outline. One ring: up to a
// spacing of 3 no disk of this radius passes between two of them with less than half a radius of
// overlap, so the inside needs none. Throws std::invalid_argument if none fits.
std::vector<Sphere> pebbles_inside(const std::vector<Eigen::Vector2d>& polygon, double radius,
                                   double spacing);

// Union of overlapping spheres or pieces, by columns along x, each integrated exactly, `cells`
// along the larger of the other two extents. The relative error of volume and gyration falls as
// 1/cells^(3/2).
Solid union_solid(const std::vector<Sphere>& spheres, int cells = 96);
Solid union_solid(const std::vector<Piece>& pieces, int cells = 96);
double union_volume(const std::vector<Sphere>& spheres, int cells = 96);  // m^3, of `union_solid`
// Surface of the union of overlapping pieces, m^2, to about a per cent: four times the mean over
// directions of the area of its projection, where a line counts as often as it enters (Crofton).
double union_area(const std::vector<Piece>& pieces, int directions = 60, int cells = 64);
// Union of disks in the plane y = 0: area, and gyration of the lamina.
Solid union_lamina(const std::vector<Sphere>& disks, int cells = 4096);

// A part of a stone.
struct StonePart {
  Template stone;                // about its own centre of mass, in its own principal axes
  Vec3 centre = Vec3::Zero();    // m, of mass, in the axes of the whole stone
  Quat axes = Quat::Identity();  // from the principal axes to those of the whole stone
};

// A stone of balls without one of them.
struct Remainder : StonePart {
  double lost = 0;                  // m^3, of the ball, what no other ball contains
  Vec3 lost_centre = Vec3::Zero();  // m, of this part, in the axes of the whole stone
};
// Volume, centre and inertia of whole stone, remainder and lost part balance to rounding errors;
// the lost part is accurate to about 1e-3 of the ball. Of a ball inside the others nothing is lost.
// Throws std::invalid_argument for pieces with several corners and for the only ball.
Remainder without_ball(const Template& whole, std::size_t which);

// The part of a stone of polyhedra with normal . x <= offset (m at unit scale, in its axes), with
// edges as rounded as before: cores end at the plane less their radius. So the two parts of a stone
// do not overlap and reach nowhere farther than the whole; the rest of its volume, along the new
// edges, is lost. None if there is hardly any volume. Its sieve size is left at 0, as it costs more
// than all else. Throws std::invalid_argument for balls.
std::optional<StonePart> part_below(const Template& whole, const Vec3& normal, double offset);

// A plane normal . x = offset (m at unit scale, in the axes of the stone) between its pieces, with
// some on either side and none on both.
struct Joint {
  Vec3 normal;
  double offset;
};
// The joints of a compound that contain a face of a piece, in the order of its faces, each once. A
// piece may reach beyond a joint by what `part_below` neglects, a thousandth of its length across
// it. None for a single piece.
std::vector<Joint> joints_of(const Template& stone);

// The stone without this volume (m^3), exactly: the core shrinks towards its centroid, and the
// rounding grows by as much as the nearest face recedes. So this face stays where it is, others
// recede the more, the farther they are from the centroid, and corners most; no part of the stone
// moves outwards, and corners keep their numbers. None if hardly any core would remain. Throws
// std::invalid_argument if the stone is not one polyhedron.
std::optional<StonePart> worn(const Template& whole, double volume);

// `count` points spread evenly through a stone, to measure fractions of it: each represents 1/count
// of its volume. Of 512 points half a per cent is on the wrong side of a straight cut in the mean,
// 3 % at most; of a lamina 1 % at most. The points are spread through the union of the pieces;
// `lamina`: disks in the plane y = 0, or all that disks of one radius enclose, if the shape's area
// is nearer to that.
std::vector<Vec3> points_within(const Template& shape, int count, bool lamina);

}  // namespace trackbed::geom
