// Field files of one instant, and the parts of grids that runs of all kinds have. Private to the
// module.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trackbed/io/fields.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::observe {

// Writes the parts that `files` asks for and enters each into the list of its series.
class FieldSeries {
 public:
  // Collective, as `write`.
  FieldSeries(const par::Comm& comm, const FieldFiles& files);
  // `grid` makes the part of this rank, and is called only if the part is asked for.
  void write(std::string_view part, const std::function<io::Grid()>& grid);
  // The same for what all ranks know: the root writes it.
  void write_on_root(std::string_view part, const std::function<io::Grid()>& grid);

 private:
  const par::Comm& comm_;
  const FieldFiles& files_;
};

// Rails as lines, wheels as disks on them.
class TrainGrid {
 public:
  TrainGrid();
  // Points of one rail, m, and, if they are known, their upward displacements, which the points
  // contain.
  void add_rail(const std::vector<Vec3>& points, const std::vector<double>& displacement = {});
  // A wheel of `radius` (m), number `wheel`, that stands on the rail at `foot`; `force`, N, on the
  // rail.
  void add_wheel(const Vec3& foot, double radius, std::size_t wheel, double force,
                 double displacement = 0);
  // With the displacements, or without if they are not known.
  io::Grid take(bool with_displacements);

 private:
  void add_cell(io::CellKind kind, const std::vector<Vec3>& corners, double wheel, double force);

  io::Grid grid_;
  std::vector<double> displacement_;  // m, of each point
  io::FieldData wheel_, force_;
};

// m, of a rail of points in order of x, where a wheel at x stands; beyond its ends as high as
// there.
double height_of_rail(const std::vector<Vec3>& points, double x);

}  // namespace trackbed::observe
