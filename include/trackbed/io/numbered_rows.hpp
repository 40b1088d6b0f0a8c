// Rows of datasets that are identified by a number, in whatever order they were written: each rank
// reads an equal part of the file and sends the rows to the ranks that want them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

// All calls are collective. Memory and messages of a rank are its part of the file and what it
// wants (par::Directory). Several ranks may want the same row.
class NumberedRows {
 public:
  // `numbers`: dataset of one integer of 0 or more for each row, each once. Throws RunError if it
  // does not contain all that are wanted.
  NumberedRows(const par::Comm& comm, const File& file, const std::string& numbers,
               std::span<const std::int64_t> wanted);
  // Rows of a dataset, in the order of `wanted`. Throws RunError if the dataset has another number
  // of rows or columns.
  std::vector<double> read(const std::string& path, std::size_t columns) const;

 private:
  par::Comm comm_;
  const File* file_;
  std::size_t rows_ = 0, wanted_ = 0;
  RowRange part_{};  // of the rows, which this rank reads
  // For each rank: the rows it wants of this rank's part, counted from its begin; and the places in
  // `wanted` of the rows it sends.
  std::vector<std::vector<std::size_t>> asked_, place_;
};

}  // namespace trackbed::io
