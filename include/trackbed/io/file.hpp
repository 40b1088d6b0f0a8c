// Parallel HDF5 behind one small class. A dataset is an array of rows; each rank holds some of
// them. Files can be read on any number of ranks. Failures throw RunError (agreed on all ranks)
// with the file and the dataset. All calls are collective unless stated otherwise.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/par/comm.hpp"

namespace trackbed::io {

// Unit and meaning of a dataset, stored as its attributes `units` and `long_name` (CF conventions).
struct Label {
  std::string unit = "-";
  std::string meaning;
};

enum class Mode { read, create, append };

// Whether a closed file is on the disk, or only with the operating system, which writes it later: a
// crash of the machine may lose it, the end of the program does not.
enum class Sync { to_disk, later };

class File {
 public:
  File(const par::Comm& comm, const std::string& path, Mode mode);
  ~File();  // closes; close() also reports errors
  File(File&&) noexcept;
  File& operator=(File&&) noexcept;
  void close(Sync sync = Sync::to_disk);
  // Datasets that are created from now on are compressed without loss (shuffle, deflate), except
  // small ones of fixed size. For files of one rank: parallel HDF5 merges the writes of compressed
  // datasets, and these do not report a full disk.
  void compress();

  // Writes all ranks' rows, in rank order, as a [rows, columns] dataset ([rows] if columns is 1).
  // T: double, float, std::int64_t, std::uint64_t, std::int32_t, std::int8_t, std::uint8_t.
  // Parent groups are created. Adds the attributes of the label and a checksum. The path must be
  // new.
  template <class T>
  void write(const std::string& path, std::span<const T> mine, std::size_t columns,
             const Label& label);
  // This rank's fraction of the rows: an even split by rank (see `row_range`).
  template <class T>
  std::vector<T> read_own_rows(const std::string& path) const;
  // All rows on every rank.
  template <class T>
  std::vector<T> read_all(const std::string& path) const;
  // Rows [begin, begin + count) on this rank.
  template <class T>
  std::vector<T> read_rows(const std::string& path, std::size_t begin, std::size_t count) const;

  // Datasets that grow: rows (all ranks' rows in rank order) are appended; the first call creates
  // the dataset. `truncate` reduces it to `rows`.
  template <class T>
  void append(const std::string& path, std::span<const T> mine, std::size_t columns,
              const Label& label);
  void truncate(const std::string& path, std::size_t rows);

  bool has(const std::string& path) const;                         // a dataset or group
  std::vector<std::size_t> extent(const std::string& path) const;  // rows, columns
  std::vector<std::string> names(const std::string& group) const;  // sorted members

  // Axes: `axis` is a dataset of one number per row or column of the dataset `path`, stored as an
  // HDF5 dimension scale, which readers of netCDF (xarray) show as the coordinate of dimension
  // 0 (rows) or 1 (columns), which must not have an axis yet.
  void set_axis(const std::string& path, std::size_t dimension, const std::string& axis);
  void make_axis(const std::string& axis);  // nothing if it is one
  bool has_axis(const std::string& path, std::size_t dimension) const;
  bool is_axis(const std::string& path) const;
  // Another name for a dataset (a hard link): readers of netCDF look for axes in the group only.
  void link(const std::string& path, const std::string& existing);

  // Attributes of a dataset or of a group (created if missing; "/" is the root of the file). An
  // existing attribute is replaced. Text is stored as a fixed-length string, UTF-8 if it is not
  // ASCII.
  void attribute(const std::string& path, const std::string& name, const std::string& value);
  void attribute(const std::string& path, const std::string& name, double value);
  void attribute(const std::string& path, const std::string& name, std::int64_t value);
  void attribute(const std::string& path, const std::string& name,
                 const std::vector<std::int64_t>& value);
  bool has_attribute(const std::string& path, const std::string& name) const;
  std::string text_attribute(const std::string& path, const std::string& name) const;
  double number_attribute(const std::string& path, const std::string& name) const;
  std::int64_t integer_attribute(const std::string& path, const std::string& name) const;

  struct Handle;  // defined within this module only
  const Handle& handle() const { return *handle_; }

 private:
  std::unique_ptr<Handle> handle_;
};

// First row and number of rows of rank `rank` when `rows` are split evenly over `size` ranks.
struct RowRange {
  std::size_t begin, count;
};
RowRange row_range(std::size_t rows, int rank, int size);

}  // namespace trackbed::io
