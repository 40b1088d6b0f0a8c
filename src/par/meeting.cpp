// A barrier that may be left: nobody who failed alone can tell the others, but it can see that they
// do not come.
#include "trackbed/par/meeting.hpp"

#include <chrono>
#include <thread>

#include "trackbed/par/mpi.hpp"

namespace trackbed::par {

struct Meeting::Room {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Request waiting = MPI_REQUEST_NULL;
};

Meeting::Meeting(const Comm& comm) : room_(std::make_unique<Room>()) {
  MPI_Comm_dup(mpi(comm), &room_->comm);
}

Meeting::~Meeting() {
  MPI_Wait(&room_->waiting, MPI_STATUS_IGNORE);
  MPI_Comm_free(&room_->comm);
}

bool Meeting::all_come(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto late = Clock::now() + std::chrono::duration<double>(seconds);
  MPI_Ibarrier(room_->comm, &room_->waiting);
  for (int here = 0;;) {
    MPI_Test(&room_->waiting, &here, MPI_STATUS_IGNORE);
    if (here != 0 || Clock::now() > late) return here != 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace trackbed::par
