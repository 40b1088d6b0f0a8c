// A failed write must not reach HDF5. If the disk is full the library aborts within its own
// bookkeeping: the file can no longer be closed, one rank may wait for another, and at MPI_Finalize
// the library uses freed memory (HDF5 1.10.8, observed in tests). Therefore the MPI-IO calls by
// which HDF5 writes are intercepted here (MPI's profiling interface, MPI 4.0 chapter 15, lets a
// program supply them): a failure is recorded, success is returned to HDF5, and the next agreement
// of the file reports the failure. Private to the module.
#pragma once

#include <string>

namespace trackbed::io {

// The text of this process's first failed write since the last call; empty if there was none.
std::string take_write_failure();

}  // namespace trackbed::io
