// What the program was built from. The header with the commit and the definitions come from CMake
// (src/model/CMakeLists.txt); compiled alone, as it changes with each commit.
#include <fmt/format.h>

#include "trackbed/model/effective.hpp"
#include "trackbed/par/library.hpp"
#include "trackbed_commit.hpp"

namespace trackbed::model {

std::string version() { return TRACKBED_VERSION; }

std::string build_description() {
  return fmt::format("commit {}; {}; {}; {}", TRACKBED_COMMIT, TRACKBED_COMPILER,
                     par::library_version(), TRACKBED_LIBRARIES);
}

}  // namespace trackbed::model
