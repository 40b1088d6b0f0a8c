// Collects the problems of a mesh file: one message per kind of problem, with its first location
// and the number of others. Matches physical groups with the deck.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fem/mesh/gmsh.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

class MeshProblems {
 public:
  explicit MeshProblems(const GmshFile& file) : file_(file) {}

  void add(const std::string& kind, const GmshFile::Element& element, std::string_view sentence);
  void add(const std::string& kind, const GmshFile::Node& node, std::string_view sentence);
  // Groups without solid or border, solids and borders without group, no top.
  void check_groups(const GroundParameters& parameters);
  // Index into parameters.solids, or parameters.borders with -1 for the top; problems are recorded.
  static constexpr int nowhere = -2;
  int solid_of(const GmshFile::Element& element, const GroundParameters& parameters);
  int border_of(const GmshFile::Element& element, const GroundParameters& parameters);
  void raise() const;  // throws InputError if there are any

 private:
  struct Kind {
    std::string name, first;
    std::size_t count;
  };
  void add(const std::string& kind, const std::string& sentence);
  void match(int dimension, const std::vector<std::string>& wanted, const char* what,
             const char* table);
  const GmshFile::Group* group_of(const GmshFile::Element& element, const char* what);

  const GmshFile& file_;
  std::vector<Kind> kinds_;
};

}  // namespace trackbed::fem
