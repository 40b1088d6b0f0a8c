// A ground of ten-node tetrahedra, whole and checked: what each is made of, and the faces of its
// borders and top. From a mesh file, or made of the sections of an embankment.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "gmsh.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// The same on every rank.
struct SolidMesh {
  // An outer face.
  struct Face {
    std::int32_t element, side;  // which of tetrahedron_faces
    BorderKind holds;            // of the top and of open faces: free
    int axis;                    // along which its normal points, 0 to 2; -1: none
    bool low;                    // against the axis
    std::int32_t border = -1;    // number of that of the deck; -1: made of sections
  };
  std::vector<Vec3> position;                         // m, in the order of the file
  std::vector<std::array<std::int32_t, 10>> element;  // nodes (tetrahedron.hpp)
  std::vector<std::int32_t> solid;                    // of each, index into Solids (lattice.hpp)
  std::vector<Face> borders, top, open;               // open: in no physical surface; ascending

  std::array<std::int32_t, 6> nodes_of(const Face& face) const;
  double depth() const;  // m, from the top down to the lowest node
};

// Of a mesh file or of the sections of an embankment, whichever the parameters have. Local.
SolidMesh make_solid_mesh(const GroundParameters& parameters);

// Reads parameters.mesh. Throws InputError with everything that is wrong with it, each with the
// line of the file: besides what cannot be read, elements that are turned inside out, stand in no
// group, are flat or do not hang together, nodes that no element has or two at one place, groups
// without solid or border and the reverse, borders inside, rollers that are not even. Local; costs
// some 700 bytes per element for the moment.
SolidMesh read_solid_mesh(const GroundParameters& parameters);
SolidMesh solid_mesh_of(const GroundParameters& parameters, GmshFile file);

}  // namespace trackbed::fem
