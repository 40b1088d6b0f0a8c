// Log lines during an operation that cannot report its progress: a large ground is assembled,
// preconditioned and solved in one call of a library.
#pragma once

#include <functional>
#include <string>
#include <thread>

namespace trackbed::model {

// From construction until destruction a separate thread calls `say` with "what: 5 s" every
// `interval` seconds. `say` must not throw and must not call MPI.
class Waiting {
 public:
  using Say = std::function<void(const std::string&)>;
  Waiting(std::string what, double interval, Say say);

 private:
  std::jthread thread_;  // its destructor requests a stop and joins
};

}  // namespace trackbed::model
