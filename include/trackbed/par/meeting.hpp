// A barrier with a time limit: whether all ranks arrive at one place in time. It uses a
// communicator of its own, so that it does not match other collective operations.
#pragma once

#include <memory>

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

class Meeting {
 public:
  explicit Meeting(const Comm& comm);  // collective
  ~Meeting();                          // waits for the ranks that have not arrived yet
  Meeting(const Meeting&) = delete;
  Meeting& operator=(const Meeting&) = delete;
  // Called once on each rank. False if not all ranks have arrived after so many seconds.
  bool all_arrive(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::par
