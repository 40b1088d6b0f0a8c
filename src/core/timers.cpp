// Names of the verbs in the timer table and in summary.json. A name with a colon is a share of the
// verb before it, not to be added to it.
#include "trackbed/core/timers.hpp"

namespace trackbed {

// The words are those of the loop itself, so that a table of times is read without the source.
std::string_view name_of(Verb verb) {
  // No default: the compiler warns about a verb without a name.
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
  // `count` is how many verbs there are, not one of them.
  return "?";
}

}  // namespace trackbed
