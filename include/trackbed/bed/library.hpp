// Named shapes of stones: generated from scans or parameters, stored in a file.
//
// A library is an HDF5 file: attributes `kind` (shapes) and `version`, the dataset `shapes/names`
// and the templates in the format of checkpoints (docs/shapes.md).
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
  std::vector<std::string> notes;  // repairs and accuracy; not stored in files
  Quat axes = Quat::Identity();    // from the shape's axes to those of the mesh; not stored
};

// How a mesh is represented: by spheres if `spheres` is above 0, else by rounded convex pieces.
// `rounding` is the radius over the diameter of the sphere of the stone's volume. Volume and
// inertia are those of the mesh.
struct MeshShape {
  double unit = 1;  // m per unit of the file
  int pieces = 1;
  int vertices = 24;  // of each piece, at most
  double rounding = 0.05;
  int spheres = 0;
};

// The templates of a bed, before scaling. Throws InputError if they cannot be generated.
// Collective.
std::vector<dem::Template> templates(const par::Comm& comm, const BedParameters& parameters,
                                     Dimension dimension);
// From an STL, PLY or OBJ file. Throws InputError with the reason if it cannot be used. Collective.
NamedShape shape_of_mesh(const par::Comm& comm, const std::string& file, const MeshShape& wanted);
// Parametric stone of this seed, extent 1 m, rounded. Throws InputError if it cannot be generated.
NamedShape parametric_shape(const geom::StoneShape& stone, double rounding, std::uint64_t seed);

// Replaces an existing file once the new one is complete. Throws RunError if it cannot be written;
// the existing file is then unchanged. Collective.
void save_library(const par::Comm& comm, const std::string& file,
                  const std::vector<NamedShape>& shapes);
// Throws InputError if a file of this name exists and is not a library. Collective.
void require_replaceable(const par::Comm& comm, const std::string& file);
// Throws InputError if it is not a library. Collective.
std::vector<NamedShape> load_library(const par::Comm& comm, const std::string& file);

}  // namespace trackbed::bed
