// Reading and writing of rows of numbers. The first row of a rank is the scan over lower ranks;
// transfers are collective: ranks without rows take part.
//
// Cost of a write: a scan, a reduction, one request per rank and a hash of the bytes. Values are
// stored in the byte order of the machine, which HDF5 records in the file and converts for other
// readers.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "io/handle.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::io {

namespace {

// Large enough that a chunk's entry in the index is small compared with it, small enough that a
// short history wastes little.
constexpr std::size_t chunk_bytes = 32768;  // of growing datasets: 4096 doubles

// Of deflate, 1 to 9. With histories of a bed, level 4 takes 12 % more time than level 1 and saves
// 1 % more.
constexpr unsigned compression_level = 1;

// Rows [begin, begin + count) of a table, all columns.
Hid selected(std::size_t all_rows, std::size_t columns, bool flat, RowRange rows) {
  const hsize_t extent[2] = {all_rows, columns};
  Hid space(H5Screate_simple(flat ? 1 : 2, extent, nullptr));
  const hsize_t start[2] = {rows.begin, 0}, count[2] = {rows.count, columns};
  if (rows.count == 0)
    // A rank without rows takes part with nothing selected: transfers are collective.
    H5Sselect_none(space.get());
  else
    H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start, nullptr, count, nullptr);
  return space;
}

// Collective for HDF5, one request per rank for MPI-IO: a rank's rows are contiguous in the file,
// so merging would gain little, and Open MPI 4.1 on three ranks and more does not report failures
// of merged writes (a full disk was not detected in file_failure_test). Compressed datasets can be
// transferred in the merged way only; one rank alone writes them.
Hid transfer_of(const Dataset& dataset) {
  Hid transfer(H5Pcreate(H5P_DATASET_XFER));
  H5Pset_dxpl_mpio(transfer.get(), H5FD_MPIO_COLLECTIVE);
  if (!dataset.compressed) H5Pset_dxpl_mpio_collective_opt(transfer.get(), H5FD_MPIO_INDIVIDUAL_IO);
  return transfer;
}

// The memory holds this rank's rows one after another. It has at least one row, also if nothing is
// selected.
Hid memory_space(std::size_t rows, std::size_t columns) {
  return selected(std::max<std::size_t>(rows, 1), columns, false, {0, rows});
}

// Reserves disk space before HDF5 writes: a full disk detected here gives one clear message; in the
// middle of a collective transfer it would leave the library's own tables unwritten. On rank 0: all
// ranks write the same file. File systems without fallocate return another error, which is not a
// reason to refuse.
std::string space_problem(const std::string& path, std::size_t bytes) {
  constexpr std::size_t headers = 1 << 16;
  const int descriptor = ::open(path.c_str(), O_RDWR);
  if (descriptor < 0) return std::strerror(errno);
  struct stat status {};
  ::fstat(descriptor, &status);
  // Beyond the present end, without changing the length that HDF5 sees.
  const bool full = ::fallocate(descriptor, FALLOC_FL_KEEP_SIZE, status.st_size,
                                static_cast<off_t>(bytes + headers)) != 0 &&
                    (errno == ENOSPC || errno == EFBIG || errno == EDQUOT);
  const std::string reason = full ? std::strerror(errno) : "";
  ::close(descriptor);
  return reason;
}

// Collective.
void reserve(const File::Handle& file, const std::string& path, std::size_t bytes) {
  const std::string reason = file.comm.root() && bytes > 0 ? space_problem(file.path, bytes) : "";
  file.comm.agree(reason.empty()
                      ? ""
                      : file.path + ": dataset " + path + " cannot be written (" + reason + ")");
}

// Collective. One column gives a dataset of one dimension, which readers treat as a list.
Dataset create_dataset(const File::Handle& file, const std::string& path, hid_t type,
                       std::size_t rows, std::size_t columns, bool grows) {
  const Hid links(H5Pcreate(H5P_LINK_CREATE)), creation(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_create_intermediate_group(links.get(), 1);
  // Every row is written immediately afterwards; writing zeros first would write the file twice.
  H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER);
  const hsize_t extent[2] = {rows, columns}, limit[2] = {H5S_UNLIMITED, columns};
  const int rank = columns == 1 ? 1 : 2;
  // Chunks for growing and for compressed datasets only: HDF5 requires them there. Others are
  // contiguous, which extents_of relies on and which reads fast.
  const std::size_t row_bytes = columns * H5Tget_size(type);
  const bool compressed = file.compresses && (grows || rows * row_bytes >= chunk_bytes);
  if (grows || compressed) {
    const hsize_t chunk[2] = {std::max<std::size_t>(1, chunk_bytes / row_bytes), columns};
    H5Pset_chunk(creation.get(), rank, chunk);
  }
  if (compressed) {
    H5Pset_shuffle(creation.get());
    H5Pset_deflate(creation.get(), compression_level);
  }
  const Hid space(H5Screate_simple(rank, extent, grows ? limit : nullptr));
  Dataset dataset{Hid(H5Dcreate2(file.file.get(), path.c_str(), type, space.get(), links.get(),
                                 creation.get(), H5P_DEFAULT)),
                  Hid(H5Tcopy(type)),
                  rows,
                  columns,
                  rank == 1,
                  compressed};
  file.agree(bool(dataset.id), "dataset " + path, "cannot be created");
  return dataset;
}

// Collective; `source` holds this rank's rows only.
void write_rows(const File::Handle& file, const std::string& path, const Dataset& dataset,
                RowRange rows, const void* source) {
  if (dataset.rows == 0) return;
  const Hid memory = memory_space(rows.count, dataset.columns);
  const Hid stored = selected(dataset.rows, dataset.columns, dataset.flat, rows);
  const Hid transfer = transfer_of(dataset);
  const char none = 0;  // HDF5 requires an address also from a rank without rows
  const bool ok = H5Dwrite(dataset.id.get(), dataset.type.get(), memory.get(), stored.get(),
                           transfer.get(), rows.count == 0 ? &none : source) >= 0;
  file.agree(ok, "dataset " + path, "cannot be written");
}

// HDF5 would convert without notice and lose digits.
void expect_type(const File::Handle& file, const std::string& path, const Dataset& dataset,
                 hid_t type) {
  file.agree(H5Tequal(dataset.type.get(), type) > 0, "dataset " + path,
             "holds " + type_name(dataset.type.get()) + ", not " + type_name(type));
}

template <class T>
std::vector<T> read_typed(const File::Handle& file, const std::string& path, const Dataset& dataset,
                          RowRange rows) {
  expect_type(file, path, dataset, native_type<T>());
  std::vector<T> values(rows.count * dataset.columns);
  read_rows_into(file, path, dataset, rows, values.data());
  return values;
}

// The conventions write a quantity without unit as "1".
void write_label(File& file, const std::string& path, const Label& label) {
  file.attribute(path, "units", label.unit == "-" ? std::string("1") : label.unit);
  file.attribute(path, "long_name", label.meaning);
}

// An error of the program, not of a file: it ends the run.
std::size_t rows_of(std::size_t values, std::size_t columns) {
  require(columns > 0 && values % columns == 0, "the values of a dataset fill whole rows");
  return values / columns;
}

// First row of this rank and, in `total`, the rows of all ranks. Collective.
RowRange place_of(const par::Comm& comm, std::size_t rows, std::size_t& total) {
  const auto mine = static_cast<std::int64_t>(rows);
  total = static_cast<std::size_t>(comm.sum(mine));
  return {static_cast<std::size_t>(comm.exclusive_scan(mine)), rows};
}

}  // namespace

Dataset open_dataset(const File::Handle& file, const std::string& path) {
  Dataset dataset;
  dataset.id = Hid(H5Dopen2(file.file.get(), path.c_str(), H5P_DEFAULT));
  file.agree(bool(dataset.id), "dataset " + path, "cannot be opened");
  const Hid space(H5Dget_space(dataset.id.get())), stored(H5Dget_type(dataset.id.get()));
  dataset.type = Hid(H5Tget_native_type(stored.get(), H5T_DIR_ASCEND));
  const int rank = H5Sget_simple_extent_ndims(space.get());
  hsize_t extent[2] = {0, 1};
  const bool ok = (rank == 1 || rank == 2) && dataset.type &&
                  H5Sget_simple_extent_dims(space.get(), extent, nullptr) == rank;
  file.agree(ok, "dataset " + path, "is not a table of numbers");
  dataset.rows = extent[0], dataset.columns = extent[1], dataset.flat = rank == 1;
  const Hid creation(H5Dget_create_plist(dataset.id.get()));
  dataset.compressed = H5Pget_nfilters(creation.get()) > 0;
  return dataset;
}

void read_rows_into(const File::Handle& file, const std::string& path, const Dataset& dataset,
                    RowRange rows, void* target) {
  const bool inside = rows.begin <= dataset.rows && rows.count <= dataset.rows - rows.begin;
  H5Eclear2(H5E_DEFAULT);
  file.agree(inside, "dataset " + path,
             "has " + std::to_string(dataset.rows) + " rows, but " + std::to_string(rows.count) +
                 " rows from row " + std::to_string(rows.begin) + " were requested");
  if (dataset.rows == 0) return;
  const Hid memory = memory_space(rows.count, dataset.columns);
  const Hid stored = selected(dataset.rows, dataset.columns, dataset.flat, rows);
  const Hid transfer = transfer_of(dataset);
  char none = 0;
  const bool ok = H5Dread(dataset.id.get(), dataset.type.get(), memory.get(), stored.get(),
                          transfer.get(), rows.count == 0 ? &none : target) >= 0;
  file.agree(ok, "dataset " + path, "cannot be read");
}

// The number of the row is included, so that exchanged rows are detected.
std::uint64_t hash_rows(const std::byte* bytes, std::size_t rows, std::size_t row_bytes,
                        std::size_t first) {
  // Unsigned overflow wraps around: addition modulo 2^64 does not depend on the order.
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < rows; ++row)
    sum += mix(hash_bytes(bytes + row * row_bytes, row_bytes) + first + row);
  return sum;
}

// The sums wrap around in the same way on all ranks, so the split does not matter.
std::uint64_t stored_hash(const File::Handle& file, const std::string& path) {
  const Dataset dataset = open_dataset(file, path);
  const RowRange mine = row_range(dataset.rows, file.comm.rank(), file.comm.size());
  std::vector<std::byte> bytes(mine.count * dataset.row_bytes());
  read_rows_into(file, path, dataset, mine, bytes.data());
  const std::uint64_t hash = hash_rows(bytes.data(), mine.count, dataset.row_bytes(), mine.begin);
  return static_cast<std::uint64_t>(file.comm.sum(static_cast<std::int64_t>(hash)));
}

template <class T>
void File::write(const std::string& path, std::span<const T> mine, std::size_t columns,
                 const Label& label) {
  std::size_t total = 0;
  const RowRange place = place_of(handle_->comm, rows_of(mine.size(), columns), total);
  // Space first, then the dataset, numbers, label, checksum: no object is created whose data cannot
  // be written.
  const std::size_t row_bytes = columns * sizeof(T);
  reserve(*handle_, path, total * row_bytes);
  const Dataset dataset = create_dataset(*handle_, path, native_type<T>(), total, columns, false);
  write_rows(*handle_, path, dataset, place, mine.data());
  write_label(*this, path, label);
  const auto hash = hash_rows(std::as_bytes(mine).data(), place.count, row_bytes, place.begin);
  attribute(path, checksum_name, handle_->comm.sum(static_cast<std::int64_t>(hash)));
}

template <class T>
std::vector<T> File::read_own_rows(const std::string& path) const {
  const Dataset dataset = open_dataset(*handle_, path);
  const par::Comm& comm = handle_->comm;
  return read_typed<T>(*handle_, path, dataset, row_range(dataset.rows, comm.rank(), comm.size()));
}

template <class T>
std::vector<T> File::read_all(const std::string& path) const {
  const Dataset dataset = open_dataset(*handle_, path);
  return read_typed<T>(*handle_, path, dataset, {0, dataset.rows});
}

template <class T>
std::vector<T> File::read_rows(const std::string& path, std::size_t begin,
                               std::size_t count) const {
  const Dataset dataset = open_dataset(*handle_, path);
  const bool inside = begin <= dataset.rows && count <= dataset.rows - begin;
  // Before memory for an invalid count is allocated; read_rows_into gives the message.
  const bool all_inside = handle_->comm.max(std::int64_t{inside ? 0 : 1}) == 0;
  if (!all_inside) read_rows_into(*handle_, path, dataset, {begin, count}, nullptr);
  return read_typed<T>(*handle_, path, dataset, {begin, count});
}

// Columns of a history grow together, one dataset each: after a kill they may have different
// lengths, so results are appended to a second file (see observe). It is therefore flushed when it
// is closed only: each flush waits for the disk.
template <class T>
void File::append(const std::string& path, std::span<const T> mine, std::size_t columns,
                  const Label& label) {
  std::size_t added = 0;
  RowRange place = place_of(handle_->comm, rows_of(mine.size(), columns), added);
  reserve(*handle_, path, added * columns * sizeof(T));
  // The same on all ranks, because metadata of a parallel file is.
  const bool fresh = !has(path);
  Dataset dataset = fresh ? create_dataset(*handle_, path, native_type<T>(), 0, columns, true)
                          : open_dataset(*handle_, path);
  expect_type(*handle_, path, dataset, native_type<T>());
  handle_->agree(
      dataset.columns == columns, "dataset " + path,
      "has " + std::to_string(dataset.columns) + " columns, not " + std::to_string(columns));
  place.begin += dataset.rows;
  dataset.rows += added;
  const hsize_t extent[2] = {dataset.rows, columns};
  handle_->agree(H5Dset_extent(dataset.id.get(), extent) >= 0, "dataset " + path, "cannot grow");
  if (added > 0) write_rows(*handle_, path, dataset, place, mine.data());
  if (fresh) write_label(*this, path, label);
}

// The space after the new end is lost to the file until it is written again.
void File::truncate(const std::string& path, std::size_t rows) {
  const Dataset dataset = open_dataset(*handle_, path);
  const hsize_t extent[2] = {rows, dataset.columns};
  handle_->agree(rows <= dataset.rows, "dataset " + path,
                 "has only " + std::to_string(dataset.rows) + " rows and cannot be cut to " +
                     std::to_string(rows));
  handle_->agree(H5Dset_extent(dataset.id.get(), extent) >= 0, "dataset " + path, "cannot be cut");
}

#define TRACKBED_IO_TYPE(T)                                                                        \
  template void File::write<T>(const std::string&, std::span<const T>, std::size_t, const Label&); \
  template void File::append<T>(const std::string&, std::span<const T>, std::size_t,               \
                                const Label&);                                                     \
  template std::vector<T> File::read_own_rows<T>(const std::string&) const;                        \
  template std::vector<T> File::read_all<T>(const std::string&) const;                             \
  template std::vector<T> File::read_rows<T>(const std::string&, std::size_t, std::size_t) const;

TRACKBED_IO_TYPE(double)
TRACKBED_IO_TYPE(float)
TRACKBED_IO_TYPE(std::int64_t)
TRACKBED_IO_TYPE(std::uint64_t)
TRACKBED_IO_TYPE(std::int32_t)
TRACKBED_IO_TYPE(std::int8_t)
TRACKBED_IO_TYPE(std::uint8_t)
#undef TRACKBED_IO_TYPE

}  // namespace trackbed::io
