// Writes fields that tests/unit/io/check_vtkhdf.py opens with VTK afterwards: see CMakeLists.txt.
#include "trackbed/io/fields.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace trackbed::io::fields_test {
namespace {

const par::Comm world() { return par::Comm::world(); }

std::string name_of(const std::string& kind) {
  return "fields_" + kind + "_" + std::to_string(world().size()) + ".hdf";
}

// Rank r holds a row of r unit cubes, so that rank 0 holds nothing.
Grid cubes(int count) {
  Grid grid;
  grid.kind = CellKind::hexahedron;
  FieldData height{"height", {"m", "of a point"}, 1, {}},
      speed{"velocity", {"m/s", "of a point"}, 3, {}};
  FieldData stress{"stress", {"Pa", "of a cell"}, 6, {}};
  for (int i = 0; i <= count && count > 0; ++i)
    for (int corner = 0; corner < 4; ++corner) {
      const double y = corner == 1 || corner == 2 ? 1 : 0, z = corner >= 2 ? 1 : 0;
      grid.points.emplace_back(i, y + 2 * world().rank(), z);
      height.values.push_back(z);
      speed.values.insert(speed.values.end(), {1, 2, z});
    }
  for (int cell = 0; cell < count; ++cell) {
    for (int node = 0; node < 8; ++node) grid.cells.push_back(4 * cell + node);
    for (int component = 0; component < 6; ++component) stress.values.push_back(component);
  }
  grid.point_data = {height, speed};
  grid.cell_data = {stress};
  return grid;
}

TEST(Fields, WritesPiecesSomeOfThemEmpty) {
  EXPECT_NO_THROW(write_fields(world(), name_of("cubes"), cubes(world().rank())));
}

// Three stones of one, two and three balls.
TEST(Fields, WritesParticlesOfSeveralPoints) {
  Grid grid;
  std::vector<std::int64_t> balls;
  for (int stone = 0; stone < 3; ++stone) {
    balls.clear();
    for (int i = 0; i <= stone; ++i) {
      balls.push_back(static_cast<std::int64_t>(grid.points.size()));
      grid.points.emplace_back(stone, world().rank(), i);
    }
    grid.add(CellKind::poly_vertex, balls);
  }
  EXPECT_EQ(grid.cell_count(), 3U);
  EXPECT_NO_THROW(write_fields(world(), name_of("particles"), grid));
}

// A point and a square on each rank but the first, which holds a pentagon.
TEST(Fields, WritesCellsOfSeveralKinds) {
  Grid grid;
  const int corners = world().rank() == 0 ? 5 : 4;
  std::vector<std::int64_t> rim;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    grid.points.emplace_back(std::cos(angle), world().rank(), std::sin(angle));
    rim.push_back(i);
  }
  if (world().rank() > 0) grid.add(CellKind::poly_vertex, std::array<std::int64_t, 1>{0});
  grid.add(CellKind::polygon, rim);
  EXPECT_EQ(grid.cell_count(), world().rank() > 0 ? 2U : 1U);
  EXPECT_NO_THROW(write_fields(world(), name_of("kinds"), grid));
}

TEST(Fields, WritesNothingAtAll) {
  EXPECT_NO_THROW(write_fields(world(), name_of("nothing"), Grid{}));
}

}  // namespace
}  // namespace trackbed::io::fields_test
