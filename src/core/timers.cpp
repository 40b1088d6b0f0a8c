#include "trackbed/core/timers.hpp"

namespace trackbed {

std::string_view name_of(Phase phase) {
  // No default: the compiler warns about a phase without a name.
  switch (phase) {
    case Phase::track:
      return "track";
    case Phase::ground:
      return "ground";
    case Phase::ground_elements:
      return "elements";
    case Phase::ground_plasticity:
      return "plasticity";
    case Phase::ground_solve:
      return "solve";
    case Phase::coupling:
      return "coupling";
    case Phase::dem:
      return "dem";
    case Phase::search:
      return "search";
    case Phase::pair_forces:
      return "pair_forces";
    case Phase::surface_forces:
      return "surface_forces";
    case Phase::integration:
      return "integration";
    case Phase::waiting:
      return "waiting";
    case Phase::halo:
      return "halo";
    case Phase::agreement:
      return "agreement";
    case Phase::partition:
      return "partition";
    case Phase::observe:
      return "observe";
    case Phase::output:
      return "output";
    case Phase::count:
      break;
  }
  // `count` is the number of phases, not one of them.
  return "?";
}

// No default here either: a part that were counted as a phase of its own would be counted twice.
Phase parent_of(Phase phase) {
  switch (phase) {
    case Phase::ground_elements:
    case Phase::ground_plasticity:
    case Phase::ground_solve:
      return Phase::ground;
    case Phase::search:
    case Phase::pair_forces:
    case Phase::surface_forces:
    case Phase::integration:
    case Phase::waiting:
    case Phase::halo:
      return Phase::dem;
    case Phase::track:
    case Phase::ground:
    case Phase::coupling:
    case Phase::dem:
    case Phase::agreement:
    case Phase::partition:
    case Phase::observe:
    case Phase::output:
    case Phase::count:
      break;
  }
  return phase;
}

}  // namespace trackbed
