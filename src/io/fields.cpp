// VTKHDF 1.0, UnstructuredGrid: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
// Each rank is one piece; the cells of a piece number its own points from 0, so no number needs to
// be translated. Alternatives: VTU with appended data writes one file per rank and an index beside
// them; XDMF needs a text file beside the data.
// Datasets go through File::write, so that a full disk gives one clear message here too.
#include "trackbed/io/fields.hpp"

#include <numeric>

#include "trackbed/core/error.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::io {

namespace {

// Name and place are prescribed by the format.
constexpr const char* root = "/VTKHDF";

std::string at(const std::string& name) { return std::string(root) + "/" + name; }

// Number of nodes of VTK's cells; the enumerators are VTK's own cell numbers.
std::size_t nodes_per_cell(CellKind kind) {
  switch (kind) {
    case CellKind::line:
      return 2;
    case CellKind::triangle:
      return 3;
    case CellKind::quad:
      return 4;
    case CellKind::hexahedron:
      return 8;
    case CellKind::quadratic_tetrahedron:
      return 10;
    case CellKind::poly_vertex:
    case CellKind::polygon:
      break;  // any number
  }
  return 0;
}

// One number per rank: that of rank r is row r, since rows follow ranks.
void write_count(File& file, const std::string& name, std::size_t count, const char* meaning) {
  const auto value = static_cast<std::int64_t>(count);
  file.write<std::int64_t>(at(name), std::span(&value, 1), 1, {"-", meaning});
}

// Pictures need no more digits than a float has (7: 0.01 mm of 100 m), and it halves the files.
template <class T>
void write_as(File& file, const std::string& name, std::span<const double> values,
              std::size_t columns, const Label& label) {
  const std::vector<T> converted(values.begin(), values.end());
  file.write<T>(at(name), converted, columns, label);
}

void write_data(File& file, const std::string& group, const std::vector<FieldData>& fields,
                std::size_t rows) {
  for (const FieldData& field : fields) {
    require(field.values.size() == rows * field.columns,
            "a field has one row for each point or cell of its grid");
    const std::string name = group + "/" + field.name;
    if (field.numbers)
      write_as<std::int64_t>(file, name, field.values, field.columns, field.label);
    else
      write_as<float>(file, name, field.values, field.columns, field.label);
  }
}

// VTKHDF requires the rows of all pieces one after the other and the counts per piece beside them,
// which is what File::write does with the rows of the ranks.
void write_cells(File& file, const Grid& grid, std::size_t cells) {
  const std::size_t nodes = nodes_per_cell(grid.kind);
  std::vector<std::int64_t> offsets(cells + 1);  // each piece has one more than cells
  std::vector<std::uint8_t> types(cells, static_cast<std::uint8_t>(grid.kind));
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const bool own = !grid.kinds.empty();
    if (own) types[cell] = static_cast<std::uint8_t>(grid.kinds[cell]);
    offsets[cell + 1] = own ? grid.ends[cell] : static_cast<std::int64_t>((cell + 1) * nodes);
  }
  file.write<std::int64_t>(at("Connectivity"), grid.cells, 1, {"-", "points of cells, per piece"});
  file.write<std::int64_t>(at("Offsets"), offsets, 1, {"-", "first point of each cell"});
  file.write<std::uint8_t>(at("Types"), types, 1, {"-", "VTK cell types"});
}

}  // namespace

void Grid::add(CellKind of, std::span<const std::int64_t> nodes) {
  require(nodes_per_cell(of) == nodes.size() || nodes_per_cell(of) == 0,
          "each cell of a grid has all its points");
  kinds.push_back(of);
  cells.insert(cells.end(), nodes.begin(), nodes.end());
  ends.push_back(static_cast<std::int64_t>(cells.size()));
}

std::size_t Grid::cell_count() const {
  return kinds.empty() ? cells.size() / nodes_per_cell(kind) : kinds.size();
}

// Collective. Points at rank borders are not merged: each piece has its own.
void write_fields(const par::Comm& comm, const std::string& path, const Grid& grid,
                  const Origin& origin, std::optional<double> time) {
  // The rows of a piece follow from the counts of the pieces before it: an incomplete cell would
  // shift all that follow.
  require(!grid.kinds.empty() || grid.cells.size() % nodes_per_cell(grid.kind) == 0,
          "each cell of a grid has all its points");
  const std::size_t cells = grid.cell_count();
  File file(comm, path, Mode::create);
  file.attribute(root, "Version", std::vector<std::int64_t>{1, 0});
  file.attribute(root, "Type", std::string("UnstructuredGrid"));
  for (const auto& [name, text] : origin) file.attribute("/", name, text);
  write_count(file, "NumberOfPoints", grid.points.size(), "points of each piece");
  write_count(file, "NumberOfCells", cells, "cells of each piece");
  write_count(file, "NumberOfConnectivityIds", grid.cells.size(), "point numbers of each piece");
  const auto* coordinates = reinterpret_cast<const double*>(grid.points.data());
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  write_as<float>(file, "Points", std::span(coordinates, 3 * grid.points.size()), 3,
                  {"m", "positions"});
  write_cells(file, grid, cells);
  write_data(file, "PointData", grid.point_data, grid.points.size());
  write_data(file, "CellData", grid.cell_data, cells);
  // The name is VTK's. One row: that of the root.
  if (time)
    file.write<double>(at("FieldData/TimeValue"), std::span(&*time, comm.root() ? 1 : 0), 1,
                       {"s", "time of the run"});
  file.close(Sync::later);  // no run depends on them, and waiting takes as long as writing
}

}  // namespace trackbed::io
