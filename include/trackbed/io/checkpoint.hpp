// A checkpoint file is either complete or absent: it is written under a temporary name, every
// dataset has a checksum, it is closed, read back and verified, renamed, and only then entered in
// the text file `latest` beside it. A run killed at any instant resumes from the last valid one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Raised with every change of what a checkpoint holds.
inline constexpr std::int64_t checkpoint_format = 16;

// Writes `folder/name` by calling `fill` with the open file, verifies it and updates
// `folder/latest`. On failure it throws RunError (on all ranks) and leaves the previous checkpoint
// untouched.
void write_checkpoint(const par::Comm& comm, const std::string& folder, const std::string& name,
                      const std::function<void(File&)>& fill);

// Opens a checkpoint for reading after checking its kind, its format and its checksums. Throws
// InputError with the defect of the file (missing, truncated, not a checkpoint, damaged dataset).
// Collective.
File open_checkpoint(const par::Comm& comm, const std::string& file);

enum class IfDamaged { refuse, pass_over };

struct CheckpointChoice {
  std::string file;
  std::vector<std::string> passed_over;  // messages about newer ones, damaged or missing
};

// The checkpoint that `path` refers to: a file itself; for a folder the one that its `latest`
// names, valid or not (refuse: open_checkpoint then reports the defect), or else the newest valid
// one in the folder by file time, then by name (pass_over). Throws InputError, with all messages,
// if there is none. Collective.
CheckpointChoice choose_checkpoint(const par::Comm& comm, const std::string& path,
                                   IfDamaged if_damaged);

}  // namespace trackbed::io
