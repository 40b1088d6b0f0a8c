// Names of the phases in the timer table and in summary.json. The time of a name with a colon is
// included in that of the phase before the colon.
#include "trackbed/core/timers.hpp"

namespace trackbed {

// The names are those used in the time loop, so that a table of times can be read without the
// source.
std::string_view name_of(Verb verb) {
  // No default: the compiler warns about a phase without a name.
  switch (verb) {
    case Verb::track:
      return "track";
    case Verb::ground:
      return "ground";
    case Verb::coupling:
      return "coupling";
    case Verb::dem:
      return "dem";
    case Verb::halo:
      return "dem: halo";
    case Verb::neighbours:
      return "dem: neighbours";
    case Verb::observe:
      return "observe";
    case Verb::output:
      return "output";
    case Verb::count:
      break;
  }
  // `count` is the number of phases, not one of them.
  return "?";
}

}  // namespace trackbed
