// The open file of io::File and operations that several sources of this module use. Private to it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/hdf5.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Owned by the File, which may be moved: the address of the handle does not change.
struct File::Handle {
  par::Comm comm;
  std::string path;
  Mode mode;
  Hid file{};
  bool compresses = false;  // new datasets

  // Throws RunError on all ranks if `ok` is false on any: "<path>: <subject> <what> (<reason>)".
  void agree(bool ok, const std::string& subject, std::string_view what) const;
};

// A dataset and its shape.
struct Dataset {
  Hid id;
  Hid type;  // native type of what is stored
  std::size_t rows = 0, columns = 1;
  bool flat = true;  // stored as [rows]
  bool compressed = false;
  std::size_t row_bytes() const { return columns * H5Tget_size(type.get()); }
};

// Collective. Throws RunError on all ranks if the dataset is missing or not a table of numbers.
Dataset open_dataset(const File::Handle& file, const std::string& path);
// Rows [begin, begin + count) of this rank into `target`; `type` describes the memory.
void read_rows_into(const File::Handle& file, const std::string& path, const Dataset& dataset,
                    RowRange rows, void* target);

// Hash of rows that does not depend on their order: the sum over rows of mix(hash(row) + row
// number), so that any split over ranks gives the same. `first` is the number of the first row of
// `bytes`.
std::uint64_t hash_rows(const std::byte* bytes, std::size_t rows, std::size_t row_bytes,
                        std::size_t first);
// The same for a stored dataset, read by all ranks together.
std::uint64_t stored_hash(const File::Handle& file, const std::string& path);

// An attribute of every dataset written by `write`.
inline constexpr const char* checksum_name = "checksum";

}  // namespace trackbed::io
