// The open file behind io::File and the few acts all parts of the room share. Private to the room.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/hdf5.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Owned by the File, which may move: the handle stays where it is.
struct File::Handle {
  par::Comm comm;
  std::string path;
  Mode mode;
  Hid file{};

  // Throws RunError on all ranks if `ok` is false on any: "<path>: <subject> <what> (<reason>)".
  void agree(bool ok, const std::string& subject, std::string_view what) const;
};

// A dataset and its shape.
struct Dataset {
  Hid id;
  Hid type;  // native type of what is stored
  std::size_t rows = 0, columns = 1;
  bool flat = true;  // stored as [rows]
  std::size_t row_bytes() const { return columns * H5Tget_size(type.get()); }
};

// Collective: agreed on all ranks.
// Throws RunError on all if the dataset is not there or no table of numbers.
Dataset open_dataset(const File::Handle& file, const std::string& path);
// Rows [begin, begin + count) of this rank into `target`; `type` describes the memory.
void read_rows_into(const File::Handle& file, const std::string& path, const Dataset& dataset,
                    Share rows, void* target);

// Order-free hash of rows: sum over rows of mix(hash(row) + row number), so that any split over
// ranks gives the same. `first` is the number of the first row of `bytes`.
std::uint64_t hash_rows(const std::byte* bytes, std::size_t rows, std::size_t row_bytes,
                        std::size_t first);
// The same for a stored dataset, read by all ranks together.
std::uint64_t stored_hash(const File::Handle& file, const std::string& path);

// An attribute of every dataset that `write` makes.
inline constexpr const char* checksum_name = "checksum";

}  // namespace trackbed::io
