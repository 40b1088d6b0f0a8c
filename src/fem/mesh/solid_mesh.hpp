// A checked ground of ten-node tetrahedra as a whole: solid of each element, and faces of borders
// and top. From a mesh file, or built from the sections of an embankment.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fem/mesh/gmsh.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// The same on every rank.
struct SolidMesh {
  // A boundary face.
  struct Face {
    std::int32_t element, side;  // index into tetrahedron_faces
    BorderKind holds;            // free for top and open faces
    int axis;                    // of its normal, 0 to 2; -1: oblique
    bool low;                    // normal against the axis
    std::int32_t border = -1;    // index in the deck; -1: built from sections
  };
  std::vector<Vec3> position;                         // m, in the order of the file
  std::vector<std::array<std::int32_t, 10>> element;  // nodes (tetrahedron.hpp)
  std::vector<std::int32_t> solid;                    // of each, index into Solids (lattice.hpp)
  std::vector<Face> borders, top, open;               // open: in no physical surface; ascending

  std::array<std::int32_t, 6> nodes_of(const Face& face) const;
  double depth() const;  // m, from the top down to the lowest node
};

// From a mesh file or from the sections of an embankment, depending on the parameters. Local.
SolidMesh make_solid_mesh(const GroundParameters& parameters);

// Reads parameters.mesh. Throws InputError with all its problems, each with the line of the file:
// besides what cannot be read, elements that are inverted, in no group, flat or not connected,
// nodes without element or at the same position, groups without solid or border and the reverse,
// borders inside the ground, rollers that are not plane. Local; needs some 700 bytes per element
// during set-up.
SolidMesh read_solid_mesh(const GroundParameters& parameters);
SolidMesh solid_mesh_of(const GroundParameters& parameters, GmshFile file);

}  // namespace trackbed::fem
