// Histories of the ground's top at the monitored line of nodes: motion in all directions of the
// model, relative to static equilibrium, and vertical stress.
#include <array>

#include "observe/column_writer.hpp"
#include "observe/impl.hpp"

namespace trackbed::observe {

namespace {

using TopState = fem::Ground::TopState;

struct Motion {
  const char *name, *unit, *words;
  Vec3 TopState::*of;
};
constexpr std::array motions = {
    Motion{"displacement", "m", "relative to static equilibrium", &TopState::displacement},
    Motion{"velocity", "m/s", "in the last window", &TopState::velocity},
    Motion{"acceleration", "m/s2", "in the last window, no filter", &TopState::acceleration}};

}  // namespace

// The vertical component has no suffix, as for sleepers.
void Results::Impl::set_ground_columns(Dimension dimension) {
  axes = dimension == Dimension::plane ? std::vector{2, 0} : std::vector{2, 0, 1};
  constexpr std::array ends = {"_x", "_y", ""};
  constexpr std::array words = {"along x, ", "along y, ", "vertical, "};
  for (const int axis : axes)
    for (const Motion& motion : motions)
      ground.push_back(
          {std::string("history/ground/") + motion.name + ends.at(static_cast<std::size_t>(axis)),
           {motion.unit, words.at(static_cast<std::size_t>(axis)) + std::string(motion.words)}});
  ground.push_back({"history/ground/sigma_z",
                    {"Pa", "vertical stress, tension positive, relative to static equilibrium"}});
}

// Only the owner of a node has its state, the other ranks add zero, so the sum is exact.
void Results::Impl::sample_ground(const fem::Ground& solid) {
  const auto& owner = solid.top_owner();
  const std::vector<std::int32_t>& nodes = recorded.nodes;
  std::vector<double> values(ground.size() * nodes.size(), 0.0);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (owner[static_cast<std::size_t>(nodes[k])] != comm.rank()) continue;
    const TopState state = solid.top_state(nodes[k]);
    std::size_t at = k;
    for (const int axis : axes)
      for (const Motion& motion : motions) {
        values[at] = (state.*motion.of)[axis] + 0.0;  // no -0, which a sum over ranks has not
        at += nodes.size();
      }
    values[at] = state.sigma_z;
  }
  comm.sum(std::span(values));
  auto from = values.begin();
  for (Column& column : ground) {
    const auto end = from + static_cast<std::ptrdiff_t>(nodes.size());
    column.width = nodes.size();
    column.values.insert(column.values.end(), from, end);
    from = end;
  }
}

void put_energies(const fem::GroundEnergies& energies, ColumnWriter& to) {
  to.put("history/energy/ground_kinetic", {"J", "of the ground"}, energies.kinetic);
  to.put("history/energy/ground_elastic",
         {"J", "of the ground, of its motion since static equilibrium"}, energies.elastic);
  if (!energies.yields) return;
  to.put("history/energy/ground_plastic", {"J", "dissipated by yielding of the ground up to now"},
         energies.plastic);
}

}  // namespace trackbed::observe
