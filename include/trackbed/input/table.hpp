// Tables of numbers beside a deck: CSV with one line of column names, then one line per row.
#pragma once

#include <string>
#include <vector>

namespace trackbed::input {

// The named columns of `path`, in the order asked for; others in the file are ignored. Separator:
// comma; blank lines and lines starting with # are skipped. The values of the column `rising`, if
// it is named, must rise from row to row. Throws InputError with one sentence per bad row
// (`file:line: ...`), all at once. `lines`: of the file, on which each row stands. Every rank reads
// the file by itself.
std::vector<std::vector<double>> read_table(const std::string& path,
                                            const std::vector<std::string>& columns,
                                            const std::string& rising = "",
                                            std::vector<int>* lines = nullptr);

}  // namespace trackbed::input
