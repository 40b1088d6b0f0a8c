// Field output for ParaView and VTK: one VTKHDF file (UnstructuredGrid) per instant and part of the
// model, written in parallel; lists of files with times make a series of them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::io {

enum class CellKind : std::uint8_t {
  poly_vertex = 2,  // points that belong together
  line = 3,
  triangle = 5,
  polygon = 7,
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
  bool numbers = false;        // of parts of the model: written as integers
};

// The part of this rank: cells refer to its own points. Cells are all of one kind, except where
// `add` has given each its own.
struct Grid {
  std::vector<Vec3> points;  // m
  CellKind kind = CellKind::line;
  std::vector<std::int64_t> cells;               // point numbers, cell after cell
  std::vector<CellKind> kinds;                   // of each cell, if they differ
  std::vector<std::int64_t> ends;                // of these cells, as numbers of entries in `cells`
  std::vector<FieldData> point_data, cell_data;  // same names on every rank

  void add(CellKind of, std::span<const std::int64_t> nodes);
  std::size_t cell_count() const;
};

// Texts that state where a file is from, by their names: attributes of the file.
using Origin = std::vector<std::pair<std::string, std::string>>;

// Writes `path` (by convention *.hdf), positions and data as 32-bit floats, and the time, s, of a
// run. Collective.
void write_fields(const par::Comm& comm, const std::string& path, const Grid& grid,
                  const Origin& origin = {}, std::optional<double> time = {});

}  // namespace trackbed::io
