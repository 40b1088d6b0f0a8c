// Parameters that have done their work: another value of them would change nothing any more, but
// would stand in the effective input of the results as if it had.
#pragma once

#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// A sentence for each parameter of `deck` that differs from the deck in `checkpoint` (at `path`)
// without effect on a run that goes on from there. Collective.
enum class GoesOn { within_the_run, in_another };  // `resume`; `start`
std::vector<std::string> spent_changes(const par::Comm& comm, const io::File& checkpoint,
                                       const std::string& path, const Model& model,
                                       const input::Deck& deck, GoesOn goes_on);

}  // namespace trackbed::app
