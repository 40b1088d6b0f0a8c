// Files named by PETSc options. Only rank 0 opens them, within collective calls: if one cannot be
// opened there the other ranks would wait forever.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace trackbed::fem {

// A message about the first file among these words that cannot be read or written, or nothing.
// `source`: where the words come from, for the message. Creates no file.
std::string unusable_file(const std::vector<std::string>& words, const std::string& source);

// Value of an option for a trial solver: its output is discarded. Nothing if the option must be
// left out for that.
std::optional<std::string> unwritten(const std::string& name, const std::string& value);

}  // namespace trackbed::fem
