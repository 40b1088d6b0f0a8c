// Four of the twelve MPI-IO calls HDF5 makes change a file; each is passed on to the MPI library
// under its second name (PMPI_). Calls by others, MPI-IO of PETSc say, would be noted here too.
#include "io/write_failures.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "trackbed/par/mpi.hpp"

namespace trackbed::io {

namespace {

// MPI calls carry no place of ours to put a note: the one static of this room, emptied by `agree`.
std::string& noted() {
  static std::string text;
  return text;
}

// The first counts: later ones follow from it.
void note(const std::string& text) {
  if (noted().empty()) noted() = text;
}

// Open MPI does not hand on the system's reason, but leaves it behind; what MPI says itself is
// worth less.
bool is_known(int system_error) {
  return system_error == ENOSPC || system_error == EFBIG || system_error == EDQUOT ||
         system_error == EIO;
}

// What MPI says of an error, where the system left no reason.
std::string words_of(int error) {
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(error, text, &length);
  return text;
}

// After a write of `count` items: a short one counts as failed (Open MPI reports a full disk so).
// HDF5 looks at the number of items written, so that is set to all of them.
// Bytes are compared: `size` is that of one item.
void check_written(int result, int system_error, int count, MPI_Datatype type, MPI_Status* status) {
  MPI_Count size = 0, written = 0;
  MPI_Type_size_x(type, &size);
  if (result == MPI_SUCCESS) MPI_Get_elements_x(status, MPI_BYTE, &written);
  if (result == MPI_SUCCESS && written == size * count) return;
  note(is_known(system_error)  ? std::strerror(system_error)
       : result != MPI_SUCCESS ? words_of(result)
                               : "only a part was written; is the disk full?");
  MPI_Status_set_elements_x(status, type, count);
}

}  // namespace

std::string take_write_failure() { return std::exchange(noted(), {}); }

// errno is read right after the call, on the same thread: the only place where the system's reason
// survives. MPI_SUCCESS whatever happened: see the header.
int written_at(decltype(&PMPI_File_write_at) write, MPI_File file, MPI_Offset offset,
               const void* data, int count, MPI_Datatype type, MPI_Status* status) {
  errno = 0;
  const int result = write(file, offset, data, count, type, status);
  check_written(result, errno, count, type, status);
  return MPI_SUCCESS;
}

// For calls that write no data but may fail for want of space.
template <class... Args>
int noted_call(int (*call)(MPI_File, Args...), MPI_File file, Args... arguments) {
  errno = 0;
  const int result = call(file, arguments...);
  if (result != MPI_SUCCESS) note(is_known(errno) ? std::strerror(errno) : words_of(result));
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
  return trackbed::io::noted_call(PMPI_File_set_size, file, size);
}

int MPI_File_sync(MPI_File file) { return trackbed::io::noted_call(PMPI_File_sync, file); }

}  // extern "C"
