// Mesh files of Gmsh as they stand: nodes, second-order tetrahedra, their faces and the physical
// groups of both. What they mean for a ground is judged in solid_mesh.cpp.
//
// ASCII of the formats 4.1 and 2.2 (Geuzaine, Remacle 2009, doi:10.1002/nme.2579; the format is in
// Gmsh's manual, "Gmsh file formats"). Elements of points and lines and sections that do not matter
// here are passed over.
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
    std::string name;  // of a group without one its tag
  };
  struct Element {
    Id tag;
    std::size_t line;
    int group;                           // index into groups; none, several
    std::array<std::int32_t, 10> nodes;  // indices; corners, then middles of edges in VTK's order
  };
  static constexpr int none = -1, several = -2;

  std::string path;
  std::vector<Node> nodes;
  std::vector<Group> groups;
  std::vector<Element> tetrahedra, triangles;  // of 10 and 6 nodes

  // "path:line: sentence"
  std::string where(std::size_t line, std::string_view sentence) const;
};

// Throws InputError: what cannot be read or is not of this kind, each with its line. Local.
GmshFile read_gmsh(const std::string& path);
// The same of a text, which `path` names in messages.
GmshFile parse_gmsh(const std::string& text, const std::string& path);

}  // namespace trackbed::fem
