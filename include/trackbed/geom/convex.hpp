// Convex cores of stones, and the templates made of them.
//
// A stone is one or more rounded convex pieces: a core swept by a sphere. A core of one vertex
// makes a sphere, of two a capsule; a flat core is a plate; any other a polyhedron with rounded
// edges.
#pragma once

#include <array>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::geom {

struct Edge {
  std::array<int, 2> vertices;
  // The face on the left of the edge from the first to the second vertex, and the face on its
  // right; -1 each for the single edge of a segment.
  std::array<int, 2> faces;
};

struct Face {
  std::vector<int> vertices;    // counter-clockwise seen from outside, three or more
  Vec3 normal = Vec3::UnitZ();  // outward, unit length
  double offset = 0;            // m; normal . x <= offset for all of the core
};

// A point, a segment, a flat polygon (two faces, back to back) or a polyhedron. Every vertex is a
// corner: none is inside an edge, a face or the solid. Coplanar triangles are one face.
struct Convex {
  std::vector<Vec3> vertices;  // m
  std::vector<Edge> edges;
  std::vector<Face> faces;
};

// Hull of points (CGAL, exact predicates: no point is lost by rounding). Corners keep the order in
// which they were given; points that are less than `merge` times the extent off a face or an edge
// are taken to be on it and are left out. Throws std::invalid_argument if there is no point or one
// is not finite.
Convex convex_hull(const std::vector<Vec3>& points, double merge = 1e-9);

// The core with these corners and faces, which are what files contain; edges, normals and offsets
// are derived. Throws std::invalid_argument if the faces are not closed or a corner is outside of a
// face by more than 1e-6 of the extent. No face: a point or a segment.
Convex convex_of(std::vector<Vec3> vertices, const std::vector<std::vector<int>>& faces);
// The same core with normals and offsets from its corners and faces alone: rotations and scalings
// change their last bits, and a file keeps corners and faces only.
Convex derived_again(const Convex& core);

struct Piece {
  Convex core;        // m at unit scale, from the centre of mass, in principal axes
  double radius = 0;  // m at unit scale, of the sphere that sweeps the core
};

Piece ball(const Vec3& centre, double radius);

// A shape of unit size; a particle is template, scale, mass, pose and motion.
struct Template {
  std::vector<Piece> pieces;
  double volume = 0;             // m^3 (plane: area, m^2) of the solid, overlaps counted once
  Vec3 gyration = Vec3::Zero();  // principal moments of inertia over mass, m^2
  double sieve = 1;              // m, smallest opening it passes
};

// Largest distance of a point of the shape from the centre of mass, m.
double bounding_radius(const Template& shape);

}  // namespace trackbed::geom
