// Shapes of stones by name: made from scans or parameters, kept in a file.
//
// A library is an HDF5 file: attributes `kind` (shapes) and `version`, the dataset `shapes/names`
// and the templates as checkpoints keep them (docs/shapes.md).
#pragma once

#include <string>
#include <vector>

#include "trackbed/bed/bed.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/geom/stone.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::bed {

struct NamedShape {
  std::string name;
  dem::Template shape;
  std::vector<std::string> notes;  // what was mended, how near it comes; not kept in files
  Quat axes = Quat::Identity();    // of a mesh, from the shape's axes to its own; not kept
};

// What is made of a mesh: spheres if `spheres` is above 0, else rounded convex pieces. `rounding`
// is the radius over the diameter of the ball of the stone's volume. Volume and inertia are the
// mesh's.
struct MeshShape {
  double unit = 1;  // m per unit of the file
  int pieces = 1;
  int vertices = 24;  // of each piece, at most
  double rounding = 0.05;
  int spheres = 0;
};

// The stones a bed is made of, before scaling. Throws InputError if they cannot be made.
// Collective.
std::vector<dem::Template> templates(const par::Comm& comm, const BedParameters& parameters,
                                     Dimension dimension);
// From an STL, PLY or OBJ file. Throws InputError with the reason if it cannot be used. Collective.
NamedShape shape_of_mesh(const par::Comm& comm, const std::string& file, const MeshShape& wanted);
// Parametric stone of this seed, extent 1 m, rounded. Throws InputError if there is none.
NamedShape parametric_shape(const geom::StoneShape& stone, double rounding, std::uint64_t seed);

// Replaces an older file of the name once the new one is complete. Throws RunError, with the old
// one as it was, if it cannot be written. Collective.
void save_library(const par::Comm& comm, const std::string& file,
                  const std::vector<NamedShape>& shapes);
// Throws InputError if there is a file of this name that is no library. Collective.
void require_replaceable(const par::Comm& comm, const std::string& file);
// Throws InputError if it is no library. Collective.
std::vector<NamedShape> load_library(const par::Comm& comm, const std::string& file);

}  // namespace trackbed::bed
