// A failed write must not reach HDF5. When the disk is full the library gives up in the middle of
// its own bookkeeping: the file can no longer be closed, one rank may wait for another, and at
// MPI_Finalize the library works on freed memory (HDF5 1.10.8, seen in tests). Therefore the MPI-IO
// calls by which HDF5 writes go through this room (MPI's profiling interface, MPI 4.0 chapter 15,
// lets a program supply them): a failure is noted here, HDF5 is told that all went well, and the
// next agreement of the file reports it. Private to the room.
#pragma once

#include <string>

namespace trackbed::io {

// This process's first failed write since the last call, in words; nothing if there was none.
std::string take_write_failure();

}  // namespace trackbed::io
