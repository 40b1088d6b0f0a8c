// The MPI library of the program.
#pragma once

#include <string>

namespace trackbed::par {

// Name and version, for example "Open MPI v4.1.4". Local; only after MPI is initialised.
std::string library_version();

}  // namespace trackbed::par
