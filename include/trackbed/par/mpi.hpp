// The MPI communicator behind a Comm, for libraries that need it (HDF5, PETSc).
#pragma once

#include <mpi.h>

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

inline MPI_Comm mpi(const Comm& comm) { return *static_cast<MPI_Comm*>(comm.native()); }

}  // namespace trackbed::par
