// Lines for whoever waits while something goes on that has no steps of its own to report: a large
// ground is assembled, preconditioned and solved in one call of a library.
#pragma once

#include <functional>
#include <string>
#include <thread>

namespace trackbed::app {

// From construction on, `say` gets "what: 5 s" each `interval` seconds, from a thread of its own,
// until the object is destroyed. `say` must not throw and must not call MPI.
class Waiting {
 public:
  using Say = std::function<void(const std::string&)>;
  Waiting(std::string what, double interval, Say say);

 private:
  std::jthread thread_;  // asked to stop and joined by its destructor
};

}  // namespace trackbed::app
