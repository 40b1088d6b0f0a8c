// An embankment of layers on natural ground as tetrahedra: its sections mapped onto a lattice of
// cells. Pure, no ranks. docs/decisions/ground_from_files.md says why tetrahedra.
#pragma once

#include "lattice.hpp"
#include "solid_mesh.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// Cells are counted as in the lattice of layers: x fastest, z from the bottom up; rows above the
// natural ground have those between two feet alone. Columns between the feet are as wide as
// the section there, so slopes are sides of cells; columns beside it stand upright.
class Embankment {
 public:
  explicit Embankment(const GroundParameters& parameters);

  const Index3& cells() const { return cells_; }
  bool holds(const Index3& cell) const;
  int layer(std::int64_t row) const { return layer_of_row_[static_cast<std::size_t>(row)]; }
  Vec3 corner(const Index3& point) const;  // m, of a point of the lattice
  bool ends_at(double y) const;            // whether the ground does, at one of its sides

 private:
  struct Slice {
    double x;  // m
    CrossSection section;
    std::vector<double> depth;  // m, of each border of rows, from the bottom up
  };
  std::vector<double> depths(const CrossSection& section) const;

  const GroundParameters& parameters_;
  Index3 cells_;
  std::int64_t natural_rows_ = 0;     // below the embankment
  std::array<std::int64_t, 2> feet_;  // first column between them, first beyond
  std::array<double, 2> side_;        // m, where the ground ends; of half an embankment the axis
  std::vector<double> across_;        // borders of columns if they stood upright
  std::vector<int> layer_of_row_;
  std::vector<Slice> slices_;  // at each border of cells along x
};

// m, of each layer at a section: the lowest of the embankment is as thick as its height leaves it,
// and the lowest of all takes up the difference.
std::vector<double> thicknesses(const GroundParameters& parameters, const CrossSection& section);

// Each cell in five tetrahedra, mirrored from one to the next so that faces fit. Throws InputError
// if sections leave cells without volume. Local.
SolidMesh embankment_mesh(const GroundParameters& parameters);

}  // namespace trackbed::fem
