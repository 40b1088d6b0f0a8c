#include "trackbed/par/library.hpp"

#include <mpi.h>

#include <array>

namespace trackbed::par {

// The library appends the package and the date of its own build after a comma.
std::string library_version() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  MPI_Get_library_version(text.data(), &length);
  const std::string all(text.data(), static_cast<std::size_t>(length));
  return all.substr(0, all.find_first_of(",\n"));
}

}  // namespace trackbed::par
