// Files that options of PETSc name. Rank 0 alone opens them, within calls of all ranks: where one
// cannot be opened there PETSc leaves the others waiting.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace trackbed::fem {

// A sentence on the first file among these words that cannot be read, or written, or nothing.
// `source`: where the words stand, for the sentence. Makes no file.
std::string unusable_file(const std::vector<std::string>& words, const std::string& source);

// An option's value for a solver that is only tried: what would be written goes nowhere. Nothing if
// the option has to be left out for that.
std::optional<std::string> unwritten(const std::string& name, const std::string& value);

}  // namespace trackbed::fem
