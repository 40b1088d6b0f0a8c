// One number over everything a file says apart from the data themselves: names, shapes, types and
// attributes (the checksums of the data among them). Private to the room.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

inline constexpr const char* signature_name = "signature";

std::vector<std::string> datasets_of(const File& file);  // full paths, sorted
bool has_attribute(const File& file, const std::string& path, const std::string& name);
// Does not count the attribute `signature` of the root itself. Collective.
std::uint64_t signature(const File& file);

}  // namespace trackbed::io
