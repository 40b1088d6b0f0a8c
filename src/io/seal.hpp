// A seal: the last bytes of a checkpoint, outside of the HDF5 part. It lists where the numbers of
// the datasets are and holds a hash of all other bytes, which are the structure of the file. It is
// compared before HDF5 opens the file, because the library may crash on damaged structure; the
// numbers have their own checksums, so that the damaged dataset can be named. Private to the
// module.
//
// The structure is small whatever the size of the model: rank 0 alone can hash it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Stored on disk as declared here: two numbers of 64 bits.
struct Extent {
  std::uint64_t offset, bytes;  // in the file
};

// Paths of all datasets, sorted. Collective.
std::vector<std::string> datasets_of(const File& file);
// Places of the numbers of all datasets in the file, by offset. Collective.
std::vector<Extent> extents_of(const File& file);

// Appends the seal to a closed file. Not collective. Returns the error, or nothing.
std::string seal(const std::string& path, const std::vector<Extent>& extents);
// The defect of a file ("is cut short (9 of more than 10 bytes)"), or nothing. Not collective.
std::string defect_of(const std::string& path);

}  // namespace trackbed::io
