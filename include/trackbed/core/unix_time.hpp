#pragma once

#include <chrono>

namespace trackbed {

// s since 1970 by the clock of the machine.
inline double unix_time() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace trackbed
