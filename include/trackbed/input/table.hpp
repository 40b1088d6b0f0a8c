// Tables of numbers that a deck refers to: CSV with one line of column names, then one line per
// row.
#pragma once

#include <string>
#include <vector>

namespace trackbed::input {

// The named columns of `path`, in the order of `columns`; other columns of the file are ignored.
// Separator: comma; blank lines and lines starting with # are skipped. The values of the column
// `rising`, if it is named, must increase from row to row. Throws InputError with one sentence per
// bad row (`file:line: ...`), all at once. `lines`: line number of each row in the file. Every rank
// reads the file itself.
std::vector<std::vector<double>> read_table(const std::string& path,
                                            const std::vector<std::string>& columns,
                                            const std::string& rising = "",
                                            std::vector<int>* lines = nullptr);

}  // namespace trackbed::input
