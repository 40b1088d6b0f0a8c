// Four of the twelve MPI-IO calls that HDF5 makes change a file; each is forwarded to the MPI
// library under its second name (PMPI_). Calls by others, for instance MPI-IO of PETSc, would be
// recorded here too.
#include "io/write_failures.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "trackbed/par/mpi.hpp"

namespace trackbed::io {

namespace {

// MPI calls have no argument in which a failure could be recorded: the one static variable of this
// module, emptied by `agree`.
std::string& pending_failure() {
  static std::string text;
  return text;
}

// The first failure is kept: later ones follow from it.
void record(const std::string& text) {
  if (pending_failure().empty()) pending_failure() = text;
}

// Open MPI does not return the system's reason but leaves it in errno; its own message is less
// informative.
bool is_known(int system_error) {
  return system_error == ENOSPC || system_error == EFBIG || system_error == EDQUOT ||
         system_error == EIO;
}

// MPI's description of an error, if there is no reason from the system.
std::string mpi_message(int error) {
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(error, text, &length);
  return text;
}

// After a write of `count` items: an incomplete one counts as failed (Open MPI reports a full disk
// in this way). HDF5 checks the number of items written, so that is set to all of them. Bytes are
// compared: `size` is that of one item.
void check_written(int result, int system_error, int count, MPI_Datatype type, MPI_Status* status) {
  MPI_Count size = 0, written = 0;
  MPI_Type_size_x(type, &size);
  if (result == MPI_SUCCESS) MPI_Get_elements_x(status, MPI_BYTE, &written);
  if (result == MPI_SUCCESS && written == size * count) return;
  record(is_known(system_error)  ? std::strerror(system_error)
         : result != MPI_SUCCESS ? mpi_message(result)
                                 : "only a part was written; is the disk full?");
  MPI_Status_set_elements_x(status, type, count);
}

}  // namespace

std::string take_write_failure() { return std::exchange(pending_failure(), {}); }

// errno is read immediately after the call, on the same thread: the system's reason is available
// only there. Always returns MPI_SUCCESS: see the header.
int written_at(decltype(&PMPI_File_write_at) write, MPI_File file, MPI_Offset offset,
               const void* data, int count, MPI_Datatype type, MPI_Status* status) {
  errno = 0;
  const int result = write(file, offset, data, count, type, status);
  check_written(result, errno, count, type, status);
  return MPI_SUCCESS;
}

// For calls that write no data but may fail for lack of space.
template <class... Args>
int checked_call(int (*call)(MPI_File, Args...), MPI_File file, Args... arguments) {
  errno = 0;
  const int result = call(file, arguments...);
  if (result != MPI_SUCCESS) record(is_known(errno) ? std::strerror(errno) : mpi_message(result));
  return MPI_SUCCESS;
}

}  // namespace trackbed::io

extern "C" {

int MPI_File_write_at(MPI_File file, MPI_Offset offset, const void* data, int count,
                      MPI_Datatype type, MPI_Status* status) {
  return trackbed::io::written_at(PMPI_File_write_at, file, offset, data, count, type, status);
}

int MPI_File_write_at_all(MPI_File file, MPI_Offset offset, const void* data, int count,
                          MPI_Datatype type, MPI_Status* status) {
  return trackbed::io::written_at(PMPI_File_write_at_all, file, offset, data, count, type, status);
}

int MPI_File_set_size(MPI_File file, MPI_Offset size) {
  return trackbed::io::checked_call(PMPI_File_set_size, file, size);
}

int MPI_File_sync(MPI_File file) { return trackbed::io::checked_call(PMPI_File_sync, file); }

}  // extern "C"
