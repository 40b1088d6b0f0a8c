// Closed triangle meshes: scanned stones to be converted to templates, and surfaces of stones for
// display.
#pragma once

#include <string>
#include <vector>

#include "trackbed/geom/convex.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

struct Mesh {
  std::vector<Vec3> vertices;                 // m
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};

// A mesh read from a file, closed and oriented outwards, and the repairs made, in words.
struct Import {
  Mesh mesh;
  std::vector<std::string> repairs;
};

enum class MeshFormat { stl, ply, obj };  // ASCII or binary as the format has it

// From the bytes of a file (CGAL). `unit`: m per unit of the file. Duplicates are merged, facets
// oriented consistently, borders stitched, specks (below 1 % of the surface) left out, small holes
// closed (border below 30 % of the extent). Throws InputError with `name` and the reason if the
// result is not one closed body without self-intersections.
Import import_mesh(const std::string& bytes, MeshFormat format, double unit,
                   const std::string& name);

Solid mesh_solid(const Mesh& mesh);
double surface_area(const Mesh& mesh);  // m^2

// Surface of a rounded piece, for display: its corners become parts of balls cut into triangles,
// `fineness` along a quarter of a turn; inside the true surface by up to radius/fineness^2.
Mesh surface_of(const Piece& piece, int fineness = 4);

// Depth of points inside a closed mesh, m; negative outside (CGAL).
std::vector<double> depths(const Mesh& mesh, const std::vector<Vec3>& points);
// The same for a rounded convex piece, exact inside; outside negative, and no more than the
// distance.
std::vector<double> depths(const Piece& piece, const std::vector<Vec3>& points);

// Hull of a mesh with at most `vertices` corners: the corner that is furthest outside the present
// hull is added until there are enough. It is inside the full hull, and equal to it if `vertices`
// suffice.
Convex reduced_hull(const std::vector<Vec3>& points, int vertices);

struct Decomposition {
  std::vector<Convex> pieces;
  double volume_error = 0;  // of their union: volume over that of the mesh, less 1
};
// Approximate convex decomposition into at most `parts` hulls of at most `vertices` corners each:
// the least convex part (volume of hull less own volume) is cut repeatedly by the plane that leaves
// the least of this difference. Fewer parts if all are convex to 0.1 % of the volume. A hull that
// lost corners is enlarged to its previous volume.
Decomposition decompose(const Mesh& mesh, int parts, int vertices);

struct Clump {
  std::vector<Sphere> spheres;
  double volume_error = 0;      // of the union: volume over that of the mesh, less 1
  double surface_error = 0;     // m, mean distance of the mesh's surface from the union's
  double surface_furthest = 0;  // m, largest
};
// At most `spheres` spheres that fill a mesh: of the spheres that touch the surface from inside,
// the one that adds most volume is taken repeatedly; then all radii are increased by the same
// amount until the union has the volume of the mesh.
Clump clump(const Mesh& mesh, int spheres);
// The same for a rounded convex piece itself, without the measures: its depths are exact and need
// no search.
std::vector<Sphere> spheres_filling(const Piece& piece, int spheres);

}  // namespace trackbed::geom
