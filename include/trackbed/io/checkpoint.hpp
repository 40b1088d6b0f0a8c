// A checkpoint file is either whole or not there: it is written under a temporary name, every
// dataset carries a checksum, it is closed, read back and verified, renamed, and only then does the
// text file `latest` beside it name it. A run killed at any instant resumes from the last good one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

inline constexpr std::int64_t checkpoint_format = 4;

// Writes `folder/name` by calling `fill` with the open file, verifies it and updates
// `folder/latest`. Throws RunError (on all ranks) and leaves the previous one untouched on failure.
void write_checkpoint(const par::Comm& comm, const std::string& folder, const std::string& name,
                      const std::function<void(File&)>& fill);

// Opens a checkpoint for reading after checking that it is one, its format and its checksums.
// Throws InputError that says what is wrong with the file (missing, cut short, not a checkpoint,
// damaged dataset). Collective.
File open_checkpoint(const par::Comm& comm, const std::string& file);

enum class IfDamaged { refuse, pass_over };

struct Chosen {
  std::string file;
  std::vector<std::string> passed_over;  // sentences about newer ones, damaged or missing
};

// The checkpoint that `path` means: a file means itself, a folder the one its `latest` names,
// whether it is good or not (refuse: open_checkpoint will say) or else the newest good one in the
// folder by file time, then by name (pass_over). Throws InputError, with all sentences, if there is
// none. Collective.
Chosen choose_checkpoint(const par::Comm& comm, const std::string& path, IfDamaged if_damaged);

}  // namespace trackbed::io
