// The senders, receivers and items are determined once; then each transfer is one message per
// neighbour and direction, without handshake. Persistent MPI requests were not taken: the buffers
// of callers move when stones are added or removed, and the time is spent in the transfer, not in
// starting it.
#include "trackbed/par/halo.hpp"

#include <mpi.h>

#include "trackbed/par/mpi.hpp"

namespace trackbed::par {

// Collective. O(ranks) once; later transfers involve neighbours only.
void Halo::connect(const Comm& comm, const std::vector<std::vector<std::int32_t>>& send_items) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  std::vector<std::vector<std::int64_t>> counts(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    if (!send_items[r].empty()) counts[r] = {static_cast<std::int64_t>(send_items[r].size())};
  // Each rank knows its own items; one exchange of counts informs the receivers.
  const auto incoming = comm.exchange(counts);
  comm_.assign(1, comm);
  neighbours_.clear();
  items_.clear();
  received_ = 0;
  for (std::size_t r = 0; r < ranks; ++r) {
    const std::size_t sends = send_items[r].size();
    // A rank that sends nothing sends no count either: no count means none.
    const std::size_t receives = incoming[r].empty() ? 0 : static_cast<std::size_t>(incoming[r][0]);
    // Neighbours are kept in the order of their ranks; items and ghosts are in that order too,
    // whatever message arrives first, so that ghosts have the same places in every run.
    if (sends == 0 && receives == 0) continue;
    neighbours_.push_back({static_cast<int>(r), items_.size(), sends, received_, receives});
    items_.insert(items_.end(), send_items[r].begin(), send_items[r].end());
    received_ += receives;
  }
}

// `target` is contiguous per neighbour in both directions: forward fills the ghosts, backward the
// list of items sent. Callers copy (pack) before, so no derived MPI datatype is needed.
void Halo::transfer(std::size_t item_bytes, std::byte* target, Direction direction) {
  // Different from the tag of Comm's exchange.
  constexpr int tag = 72;
  const MPI_Comm mpi_comm = mpi(comm_.front());
  thread_local std::vector<MPI_Request> requests;  // keeps its capacity: no allocation per step
  requests.clear();
  for (const Neighbour& n : neighbours_) {
    const auto [begin, count] = direction == Direction::forward
                                    ? std::pair(n.receive_begin, n.receive_count)
                                    : std::pair(n.send_begin, n.send_count);
    if (count > 0)
      MPI_Irecv(target + begin * item_bytes, static_cast<int>(count * item_bytes), MPI_BYTE, n.rank,
                tag, mpi_comm, &requests.emplace_back());
  }
  for (const Neighbour& n : neighbours_) {
    const auto [begin, count] = direction == Direction::forward
                                    ? std::pair(n.send_begin, n.send_count)
                                    : std::pair(n.receive_begin, n.receive_count);
    if (count > 0)
      MPI_Isend(send_.data() + begin * item_bytes, static_cast<int>(count * item_bytes), MPI_BYTE,
                n.rank, tag, mpi_comm, &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

}  // namespace trackbed::par
