// A seal: the last bytes of a checkpoint, outside of what HDF5 knows. It lists where the datasets'
// numbers lie and holds a hash of all other bytes, which are the file's structure. It is compared
// before HDF5 sees the file, because the library may crash on damaged structure; the numbers have
// their own checksums, so that the damaged dataset can be named. Private to the room.
//
// The structure is small whatever the model's size: rank 0 alone can hash it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

// On disk as it stands here: two numbers of 64 bits.
struct Extent {
  std::uint64_t offset, bytes;  // in the file
};

std::vector<std::string> datasets_of(
    const File& file);  // Where the numbers of all datasets lie, by offset. Collective.
std::vector<Extent> extents_of(const File& file);

// Appends the seal to a closed file. Not collective. Returns what went wrong, or nothing.
std::string seal(const std::string& path, const std::vector<Extent>& extents);
// What is wrong with a file ("is cut short (9 of more than 10 bytes)"), or nothing. Not collective.
std::string why_not_whole(const std::string& path);

}  // namespace trackbed::io
