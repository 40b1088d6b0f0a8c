// Opening, closing and listing of a file. Datasets are in dataset.cpp, attributes in
// attributes.cpp.
//
// Every rank opens the file through MPI-IO, also a single one, so that there is one code path.
// Format: HDF5 1.8 (superblock 2, object headers 2). Its metadata blocks carry checksums, so that
// the library detects damage, and unlike in the 1.10 format a file whose writer was killed is not
// marked as open for ever.
#include "trackbed/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "io/handle.hpp"
#include "io/write_failures.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::io {

namespace {

// Opens the file by the operating system first: its error messages ("Permission denied") are better
// than those of MPI. Creates the file if required, so that the later open by all ranks succeeds. On
// rank 0.
std::string open_problem(const std::string& path, Mode mode) {
  const int flags = mode == Mode::read     ? O_RDONLY
                    : mode == Mode::create ? O_RDWR | O_CREAT
                                           : O_RDWR;
  const int descriptor = ::open(path.c_str(), flags, 0666);
  if (descriptor < 0) return std::strerror(errno);
  struct stat status {};
  ::fstat(descriptor, &status);
  ::close(descriptor);
  return S_ISREG(status.st_mode) ? "" : "not a regular file";
}

// HDF5 1.10 writes its changed metadata when they exceed 256 KB, also in the middle of a collective
// write of a growing dataset, which then fails (MPI_ERR_TYPE; about 900 histories in one file).
// This is the largest value that the library accepts, for some 100,000 datasets.
void delay_metadata(const Hid& access) {
  H5AC_cache_config_t config{};
  config.version = H5AC__CURR_CACHE_CONFIG_VERSION;
  H5Pget_mdc_config(access.get(), &config);
  config.dirty_bytes_threshold = 32 << 20;
  H5Pset_mdc_config(access.get(), &config);
}

// Collective.
Hid open_file(const par::Comm& comm, const std::string& path, Mode mode) {
  const Hid access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fapl_mpio(access.get(), par::mpi(comm), MPI_INFO_NULL);
  delay_metadata(access);
  // Both bounds are set: a newer library would otherwise choose newer structures.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18);
  // Results grow by append, which opens an existing file; create begins with an empty one.
  if (mode == Mode::create)
    return Hid(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()));
  const unsigned flags = mode == Mode::read ? H5F_ACC_RDONLY : H5F_ACC_RDWR;
  return Hid(H5Fopen(path.c_str(), flags, access.get()));
}

// Releases disk space reserved beyond the end of the file (see reserve in dataset.cpp). On rank 0,
// after the file is closed.
void trim(const File::Handle& file) {
  if (!file.comm.root() || file.mode == Mode::read) return;
  struct stat status {};
  if (::stat(file.path.c_str(), &status) == 0 && ::truncate(file.path.c_str(), status.st_size) != 0)
    return;  // some blocks stay reserved, which is harmless
}

herr_t collect_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

}  // namespace

// Every collective call of this module ends here: a failure of one rank is an exception on all, at
// the same place, so that no rank waits in the next call. A write failure that HDF5 did not notice
// (write_failures.hpp) is reported here as well, and its reason takes precedence.
void File::Handle::agree(bool ok, const std::string& subject, std::string_view what) const {
  const std::string reason = ok ? "" : hdf5_reason();
  const std::string unwritten = take_write_failure();
  const std::string start = fmt::format("{}: {}{}", path, subject, subject.empty() ? "" : " ");
  std::string problem;
  if (!ok) problem = fmt::format("{}{}{}", start, what, reason);
  if (!unwritten.empty()) problem = fmt::format("{}cannot be written ({})", start, unwritten);
  comm.agree(problem);
}

File::File(const par::Comm& comm, const std::string& path, Mode mode)
    : handle_(std::make_unique<Handle>(Handle{comm, path, mode})) {
  silence_hdf5();
  const std::string verb = mode == Mode::create ? "cannot be created" : "cannot be opened";
  const std::string reason = comm.root() ? open_problem(path, mode) : "";
  comm.agree(reason.empty() ? "" : path + ": " + verb + " (" + reason + ")");
  handle_->file = open_file(comm, path, mode);
  handle_->agree(bool(handle_->file), "", verb);
}

// Also called with an open file while an exception propagates: it must not throw and not agree, but
// has to close on every rank, since H5Fclose of a parallel file is collective.
File::~File() {
  if (handle_ && handle_->file) {
    Hid file = std::move(handle_->file);
    if (handle_->mode != Mode::read) H5Fflush(file.get(), H5F_SCOPE_GLOBAL);
    file.close();
    trim(*handle_);
    take_write_failure();  // cannot be reported here: see close()
  }
}
File::File(File&&) noexcept = default;
File& File::operator=(File&&) noexcept = default;

// Collective; throws where the destructor may not.
void File::close(Sync sync) {
  if (!handle_->file) return;
  Hid file = std::move(handle_->file);
  // The flush also requests that the operating system writes the data to the disk (MPI_File_sync);
  // the close writes all to the operating system.
  const bool flushed = handle_->mode == Mode::read || sync == Sync::later ||
                       H5Fflush(file.get(), H5F_SCOPE_GLOBAL) >= 0;
  const bool closed = file.close();
  trim(*handle_);
  handle_->agree(flushed && closed, "", "cannot be completed");
}

void File::compress() {
  require(handle_->comm.size() == 1, "a file is compressed by one rank");
  handle_->compresses = true;
}

// A local call with the same result on all ranks, as for metadata.
bool File::has(const std::string& path) const {
  // HDF5 requires every parent group to be checked before the last name.
  for (std::size_t end = 0; end != std::string::npos;) {
    end = path.find('/', end + 1);
    const std::string part = path.substr(0, end);
    if (part.empty() || part == "/") continue;
    if (H5Lexists(handle_->file.get(), part.c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return true;
}

// Rows and columns; a list has one column. Collective.
std::vector<std::size_t> File::extent(const std::string& path) const {
  const Dataset dataset = open_dataset(*handle_, path);
  return {dataset.rows, dataset.columns};
}

// Sorted, so that the order does not depend on HDF5. Collective.
std::vector<std::string> File::names(const std::string& group) const {
  const Hid opened(H5Gopen2(handle_->file.get(), group.c_str(), H5P_DEFAULT));
  std::vector<std::string> found;
  const bool ok = opened && H5Literate(opened.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
                                       collect_name, &found) >= 0;
  handle_->agree(ok, "group " + group, "cannot be listed");
  std::sort(found.begin(), found.end());
  return found;
}

// Contiguous blocks that differ by one row at most; the first rows % n ranks have one more.
RowRange row_range(std::size_t rows, int rank, int size) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(size);
  const std::size_t begin = rows / n * r + std::min(r, rows % n);
  return {begin, rows / n + (r < rows % n ? 1 : 0)};
}

}  // namespace trackbed::io
