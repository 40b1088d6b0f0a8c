// Parameters that have no effect on the rest of a run: a new value would be in the effective input
// of the results although it was never used.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// A sentence for each parameter of `deck` that differs from the deck in `checkpoint` (at `path`)
// without effect on a run that continues from there. Collective.
enum class Continuation { within_the_run, in_another };  // `resume`; `start`
std::vector<std::string> spent_changes(const par::Comm& comm, const io::File& checkpoint,
                                       const std::string& path, const model::Model& model,
                                       const input::Deck& deck, Continuation goes_on);

}  // namespace trackbed::app
