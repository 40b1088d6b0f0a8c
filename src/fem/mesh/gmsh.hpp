// Content of mesh files of Gmsh: nodes, second-order tetrahedra, their faces and the physical
// groups of both. Their meaning for a ground is checked in solid_mesh.cpp.
//
// ASCII formats 4.1 and 2.2 (Geuzaine, Remacle 2009, doi:10.1002/nme.2579; the format is in Gmsh's
// manual, "Gmsh file formats"). Point and line elements and unused sections are skipped.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "trackbed/core/types.hpp"

namespace trackbed::fem {

struct GmshFile {
  struct Node {
    Id tag;
    Vec3 at;  // as in the file, by convention m
    std::size_t line;
  };
  struct Group {
    int dimension, tag;
    std::string name;  // or its tag if the group has no name
  };
  struct Element {
    Id tag;
    std::size_t line;
    int group;                           // index into groups; none, several
    std::array<std::int32_t, 10> nodes;  // indices; corners, then mid-edge nodes in VTK's order
  };
  static constexpr int none = -1, several = -2;

  std::string path;
  std::vector<Node> nodes;
  std::vector<Group> groups;
  std::vector<Element> tetrahedra, triangles;  // of 10 and 6 nodes

  // "path:line: sentence"
  std::string where(std::size_t line, std::string_view sentence) const;
};

// Throws InputError with all that cannot be read or is not supported, each with its line. Local.
GmshFile read_gmsh(const std::string& path);
// The same for a text; messages name `path`.
GmshFile parse_gmsh(const std::string& text, const std::string& path);

}  // namespace trackbed::fem
