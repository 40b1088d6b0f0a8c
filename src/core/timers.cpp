#include "trackbed/core/timers.hpp"

namespace trackbed {

std::string_view name_of(Verb verb) {
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
  return "?";
}

}  // namespace trackbed
