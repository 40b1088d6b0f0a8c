// An embankment of layers on natural ground as tetrahedra: its sections mapped onto a lattice of
// cells. Pure, no ranks. docs/decisions/ground_from_files.md gives the reasons for tetrahedra.
#pragma once

#include "fem/mesh/lattice.hpp"
#include "fem/mesh/solid_mesh.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// m, between places that are meant to be one: the ground ends at a foot this near to its side.
constexpr double same_place = 1e-6;

// Cells are numbered as in the lattice of layers: x fastest, z from the bottom up; rows above the
// natural ground contain only cells between the two feet. Columns between the feet are as wide as
// the section there, so slopes are sides of cells; columns beside it are vertical.
class Embankment {
 public:
  explicit Embankment(const GroundParameters& parameters);

  const Index3& cells() const { return cells_; }
  bool holds(const Index3& cell) const;
  int layer(std::int64_t row) const { return layer_of_row_[static_cast<std::size_t>(row)]; }
  Vec3 corner(const Index3& point) const;  // m, of a point of the lattice
  bool ends_at(double y) const;            // whether y is at one side of the ground

 private:
  struct Slice {
    double x;  // m
    CrossSection section;
    std::vector<double> depth;  // m, of each row border, from the bottom up
  };
  std::vector<double> depths(const CrossSection& section) const;

  const GroundParameters& parameters_;
  Index3 cells_;
  std::int64_t natural_rows_ = 0;     // below the embankment
  std::array<std::int64_t, 2> feet_;  // first column between them, first column beyond
  std::array<double, 2> side_;        // m, sides of the ground; or one is the axis
  std::vector<double> across_;        // borders of vertical columns
  std::vector<int> layer_of_row_;
  std::vector<Slice> slices_;  // at each border of cells along x
};

// m, thickness of each layer at a section: the height of the section decides that of the lowest
// layer of the embankment, and the lowest layer of all compensates the difference.
std::vector<double> thicknesses(const GroundParameters& parameters, const CrossSection& section);

// Each cell is cut into five tetrahedra, mirrored from one cell to the next so that faces conform.
// Throws InputError if sections yield cells without volume. Local.
SolidMesh embankment_mesh(const GroundParameters& parameters);

}  // namespace trackbed::fem
