// Whether all ranks come to one place in time. On a communicator of its own: ranks that wait for
// something else do not meet it there.
#pragma once

#include <memory>

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

class Meeting {
 public:
  explicit Meeting(const Comm& comm);  // collective
  ~Meeting();                          // waits for those who have not come yet
  Meeting(const Meeting&) = delete;
  Meeting& operator=(const Meeting&) = delete;
  // Once on each rank. False after so many seconds without all others.
  bool all_come(double seconds);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::par
