// Histories of sleepers and rails that are solids.
#include "observe/room.hpp"

namespace trackbed::observe {

void Results::Room::sample_solids(const SolidState& state) {
  if (solid.empty())
    solid = {{"history/solid/seat_displacement",
              {"m", "vertical, of each rail seat, from where it was placed"}},
             {"history/solid/bending_stress",
              {"Pa", "along each sleeper at its lower face: below its seats, then in its middle"}},
             {"history/solid/rail_displacement",
              {"m", "vertical, of the rail above each seat, from where it was placed"}}};
  const auto put = [](Column& column, const std::vector<double>& values) {
    column.width = values.size();
    column.values.insert(column.values.end(), values.begin(), values.end());
  };
  put(solid[0], state.seat_displacement);
  put(solid[1], state.bending_stress);
  put(solid[2], state.rail_displacement);
}

}  // namespace trackbed::observe
