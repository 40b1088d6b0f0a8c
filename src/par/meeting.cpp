// A barrier with a time limit: a rank that failed alone cannot inform the others, but they can
// detect that it does not arrive.
#include "trackbed/par/meeting.hpp"

#include <chrono>
#include <thread>

#include "trackbed/par/mpi.hpp"

namespace trackbed::par {

struct Meeting::Impl {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Request waiting = MPI_REQUEST_NULL;
};

Meeting::Meeting(const Comm& comm) : impl_(std::make_unique<Impl>()) {
  MPI_Comm_dup(mpi(comm), &impl_->comm);
}

Meeting::~Meeting() {
  MPI_Wait(&impl_->waiting, MPI_STATUS_IGNORE);
  MPI_Comm_free(&impl_->comm);
}

bool Meeting::all_arrive(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto late = Clock::now() + std::chrono::duration<double>(seconds);
  MPI_Ibarrier(impl_->comm, &impl_->waiting);
  for (int here = 0;;) {
    MPI_Test(&impl_->waiting, &here, MPI_STATUS_IGNORE);
    if (here != 0 || Clock::now() > late) return here != 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace trackbed::par
