// What the files that a deck names hold, as hashes that checkpoints keep: a state goes on with
// files of the same content, wherever they lie by now.
#pragma once

#include <map>
#include <string>

#include "app/deck_values.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// "key = hash" line by line, as `values_of` reads them. A file that cannot be read has no line.
// `effective`: as `input::effective` writes it. Collective: rank 0 reads the files.
std::string contents_of_files(const par::Comm& comm, const std::string& effective);

// The values of a checkpoint's deck with the names that files have in the deck `effective` where
// they hold what those of the checkpoint did: one that was moved is no other one. Collective.
Values with_moved_files(const par::Comm& comm, const io::File& checkpoint, Values then,
                        const std::string& effective);

// Of each parameter that names a file: a sentence if it holds something else than when the
// checkpoint was made. One of a program that did not note that has none. Collective.
std::map<std::string, std::string> changed_files(const par::Comm& comm, const io::File& checkpoint,
                                                 const std::string& path,
                                                 const std::string& effective,
                                                 const input::Deck& deck);

}  // namespace trackbed::app
