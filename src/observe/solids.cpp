// Histories of solid sleepers and rails.
#include "observe/impl.hpp"

namespace trackbed::observe {

void Results::Impl::sample_solids(const SolidState& state) {
  if (solid.empty())
    solid = {{"history/solid/seat_displacement",
              {"m", "vertical, of each rail seat, since the sleepers were placed"}},
             {"history/solid/bending_stress",
              {"Pa", "along the sleeper, at its lower face: below the seats, then in the middle"}},
             {"history/solid/rail_displacement",
              {"m", "vertical, of the rail above each seat, since the rail was placed"}}};
  const auto put = [](Column& column, const std::vector<double>& values) {
    column.width = values.size();
    column.values.insert(column.values.end(), values.begin(), values.end());
  };
  put(solid[0], state.seat_displacement);
  put(solid[1], state.bending_stress);
  put(solid[2], state.rail_displacement);
}

}  // namespace trackbed::observe
