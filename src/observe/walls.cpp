// Histories of walls and platen. Their columns are defined by the first row, which has all walls of
// the run.
#include "observe/impl.hpp"

namespace trackbed::observe {

namespace {

void put(Column& column, const Vec3& value) {
  column.width = 3;
  column.values.insert(column.values.end(), value.data(), value.data() + 3);
}

}  // namespace

void Results::Impl::sample_walls(std::span<const WallState> walls) {
  if (wall.empty())
    for (const WallState& one : walls) {
      const std::string group = "history/wall/" + one.name + "/";
      wall.push_back({group + "force", {"N", "of the stones, x y z, mean of the last window"}});
      wall.push_back({group + "displacement", {"m", "x y z, since the wall was built"}});
    }
  for (std::size_t k = 0; k < walls.size(); ++k) {
    put(wall[2 * k], walls[k].force);
    put(wall[2 * k + 1], walls[k].displacement);
  }
}

// Forces are positive upwards, as in the rest of the file; pressure is positive in compression.
void Results::Impl::sample_platen(const PlatenState& state) {
  if (platen.empty())
    platen = {{"history/platen/z", {"m", "height of the lower face; 0 while there is no platen"}},
              {"history/platen/pressure",
               {"Pa", "vertical force divided by area, averaged by the servo"}},
              {"history/platen/force", {"N", "of the stones, x y z, mean of the last window"}}};
  platen[0].width = platen[1].width = 1;
  platen[0].values.push_back(state.z);
  platen[1].values.push_back(state.pressure);
  put(platen[2], state.force);
}

}  // namespace trackbed::observe
