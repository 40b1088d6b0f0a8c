// A file that replaces another of its name only when it is complete.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "trackbed/par/comm.hpp"

namespace trackbed::io {

// Lets `write` make `path`.part and gives it its name: a reader meets the old file or the new one,
// also after a crash of the machine. If `write` throws (the same on all ranks), the old file is as
// it was and no part stays. Throws RunError on all ranks if it cannot be put in place. Collective.
void replace_file(const par::Comm& comm, const std::string& path,
                  const std::function<void(const std::string& part)>& write);

// The last step alone; on one rank. Returns what went wrong, or nothing.
std::string put_in_place(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace trackbed::io
