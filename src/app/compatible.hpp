// Whether a deck may go on from the state that another deck made.
#pragma once

#include <string>
#include <vector>

#include "app/deck_values.hpp"
#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// What `deck` says, all defaults written out, against the deck stored in `checkpoint`, for the
// parameters that the stored state depends on. Throws InputError with a sentence for each that
// differs, and for each of them that names a file which now holds something else. `path`: of the
// checkpoint, for the sentences. Collective.
void require_same_model(const par::Comm& comm, const io::File& checkpoint, const std::string& path,
                        const std::string& effective, const input::Deck& deck);

// The deck stored in a checkpoint, as far as `now` has more parameters with their defaults: one
// that came after the program which wrote it leaves all as it was unless it is given. Collective.
Values stored_values(const io::File& checkpoint, const Values& now);

// Number of the stage of `model` that follows the one `checkpoint` was written after. Stages are
// matched by name, so that the deck may have others before and after. Throws InputError if it was
// written within a stage or the deck does not have that stage. Collective.
std::size_t stage_after(const io::File& checkpoint, const std::string& path, const Model& model,
                        const input::Deck& deck);

// Contacts whose springs differ from those that the state was at rest with, a sentence each: their
// overlaps stay and so their forces and energies jump.
std::vector<std::string> changed_springs(const io::File& checkpoint, const std::string& path,
                                         const std::string& effective, const input::Deck& deck);

}  // namespace trackbed::app
