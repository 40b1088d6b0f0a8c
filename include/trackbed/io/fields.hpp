// Field output for ParaView and VTK: one VTKHDF file (UnstructuredGrid) per instant and part of the
// model, written in parallel; lists of files with times make a series of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::io {

enum class CellKind : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  quad = 9,
  hexahedron = 12,
  quadratic_tetrahedron = 24
};

// Names can be typed in calculators and scripts: letters, digits and underscores.
struct FieldData {
  std::string name;            // "velocity"
  Label label;                 // unit and meaning, attributes of the dataset
  std::size_t columns = 1;     // 1, 3, 6 or 9
  std::vector<double> values;  // rows x columns
};

// The part of this rank: cells refer to its own points.
struct Grid {
  std::vector<Vec3> points;  // m
  CellKind kind = CellKind::vertex;
  std::vector<std::int64_t> cells;               // point numbers, cell after cell
  std::vector<FieldData> point_data, cell_data;  // same names on every rank
};

// Writes `path` (by convention *.vtkhdf). Collective.
void write_fields(const par::Comm& comm, const std::string& path, const Grid& grid);

}  // namespace trackbed::io
