// Hashes of the files that a deck names, stored in checkpoints: a run is continued with files of
// the same content, also if they were moved.
#pragma once

#include <map>
#include <string>

#include "app/deck/deck_values.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// "key = hash" line by line, as `values_of` reads them. A file that cannot be read has no line.
// `effective`: as `input::effective` writes it. Collective: rank 0 reads the files.
std::string contents_of_files(const par::Comm& comm, const std::string& effective);

// The values of a checkpoint's deck, in which names of files are replaced by those in the deck
// `effective` where the contents are equal: a moved file is not a change. Collective.
Values with_moved_files(const par::Comm& comm, const io::File& checkpoint, Values then,
                        const std::string& effective);

// A sentence for each parameter that names a file whose content has changed since the checkpoint
// was written; none if its program did not store hashes. Collective.
std::map<std::string, std::string> changed_files(const par::Comm& comm, const io::File& checkpoint,
                                                 const std::string& path,
                                                 const std::string& effective,
                                                 const input::Deck& deck);

}  // namespace trackbed::app
