// Checks whether a deck can continue from the state of another deck.
#pragma once

#include <string>
#include <vector>

#include "app/deck/deck_values.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Compares `model` with the deck stored in `checkpoint`. Throws InputError with a sentence for each
// parameter that differs and is fixed by a part of the stored state, and for each such parameter
// that names a file whose content has changed. `path`: of the checkpoint, for the sentences.
// Returns whether no parameter differs, fixed or not. Collective.
bool require_same_model(const par::Comm& comm, const io::File& checkpoint, const std::string& path,
                        const model::Model& model, const input::Deck& deck);

// The deck stored in a checkpoint, completed with the defaults of parameters that only `now` has: a
// parameter newer than the program that wrote the file has its default there. Collective.
Values stored_values(const io::File& checkpoint, const Values& now);

// Number of the stage of `model` that follows the one `checkpoint` was written after. Stages are
// matched by name, so that the deck may have others before and after. Throws InputError if it was
// written within a stage or the deck does not have that stage. Collective.
std::size_t stage_after(const io::File& checkpoint, const std::string& path,
                        const model::Model& model, const input::Deck& deck);

// A sentence for each contact law whose stiffness differs from that of the stored equilibrium, and
// one for all if the checkpoint was written in a stage with softer contacts:
// overlaps are kept, so that forces and energies jump.
std::vector<std::string> changed_springs(const io::File& checkpoint, const std::string& path,
                                         const std::string& effective, const input::Deck& deck);

// A sentence for each parameter that describes the stones of a bed and differs from that of the
// cell from which they are copied.
std::vector<std::string> changed_stones(const io::File& cell, const std::string& path,
                                        const std::string& effective, const input::Deck& deck);

}  // namespace trackbed::app
