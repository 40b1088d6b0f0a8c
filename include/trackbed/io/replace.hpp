// Replacement of a file only when the new one is complete.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "trackbed/par/comm.hpp"

namespace trackbed::io {

// Calls `write` with the name `path`.part and then renames that file to `path`: a reader sees the
// old file or the new one, also after a crash of the machine. If `write` throws (the same on all
// ranks), the old file is unchanged and the part is removed. Throws RunError on all ranks if it
// cannot be put in place. Collective.
void replace_file(const par::Comm& comm, const std::string& path,
                  const std::function<void(const std::string& part)>& write);

// The same for a file that rank 0 writes alone: `write` is called there only, and may throw what it
// likes.
void replace_file_on_root(const par::Comm& comm, const std::string& path,
                          const std::function<void(const std::string& part)>& write);

// The last step alone; on one rank. Returns the error, or nothing.
std::string put_in_place(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace trackbed::io
