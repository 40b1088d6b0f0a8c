// Comm by MPI; messages of every sub-step are in halo.cpp. Return codes are not examined: MPI's own
// error handler ends the job on any error, and a program that has lost a rank could do nothing
// else. Cost: a reduction is O(log ranks) messages, all_gather and exchange O(ranks) per rank.
// Those two are for setup, rebalancing and files; data of every sub-step go through Halo.
#include "trackbed/par/comm.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <climits>
#include <cstdlib>

#include "trackbed/core/error.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::par {

namespace {

// MPI counts are int; an overflow of the count must not go unnoticed.
int checked_int(std::size_t count) {
  if (count > INT_MAX)
    throw RunError(
        fmt::format("an MPI message would have {} items (bytes or numbers); at most {} are "
                    "possible; use more ranks (mpirun -n)",
                    count, INT_MAX));
  return static_cast<int>(count);
}

template <class T>
T reduced(const Comm& comm, T value, MPI_Datatype type, MPI_Op operation) {
  T result{};
  MPI_Allreduce(&value, &result, 1, type, operation, mpi(comm));
  return result;
}

// One more than counts: the last offset is the total.
std::vector<int> offsets_of(const std::vector<int>& counts) {
  std::vector<int> offsets(counts.size() + 1, 0);
  for (std::size_t i = 0; i < counts.size(); ++i) offsets[i + 1] = offsets[i] + counts[i];
  return offsets;
}

}  // namespace

// No thread support is requested: each rank is one thread.
// Files go through Open MPI's ROMIO (romio321, in version 5 romio341) unless the environment
// selects otherwise. Its OMPIO (4.1) opens a named semaphore per file name on the node: a run
// killed at that moment leaves it locked, and the next run that opens a file of that name, in any
// folder, waits for ever.
Environment::Environment(int& argc, char**& argv) {
  setenv("OMPI_MCA_io", "^ompio", 0);
  MPI_Init(&argc, &argv);
}
Environment::~Environment() { MPI_Finalize(); }

// Rank and size are read once: they never change.
Comm::Comm(std::shared_ptr<void> handle) : handle_(std::move(handle)) {
  MPI_Comm_rank(mpi(*this), &rank_);
  MPI_Comm_size(mpi(*this), &size_);
}

// Plain handles, never duplicated: all messages are ours, tags separate exchange from halo, and
// libraries (PETSc, HDF5) duplicate the communicators they are given. So nothing needs freeing
// before MPI_Finalize.
Comm Comm::world() { return Comm(std::make_shared<MPI_Comm>(MPI_COMM_WORLD)); }
Comm Comm::self() { return Comm(std::make_shared<MPI_Comm>(MPI_COMM_SELF)); }

void Comm::barrier() const { MPI_Barrier(mpi(*this)); }
// The order of a sum of doubles is chosen by MPI and may change with the number of ranks: for
// reported values, or where all ranks but one add zero; quantities that affect the motion use exact
// sums.
double Comm::sum(double value) const { return reduced(*this, value, MPI_DOUBLE, MPI_SUM); }
double Comm::max(double value) const { return reduced(*this, value, MPI_DOUBLE, MPI_MAX); }
double Comm::min(double value) const { return reduced(*this, value, MPI_DOUBLE, MPI_MIN); }
std::int64_t Comm::sum(std::int64_t value) const {
  return reduced(*this, value, MPI_INT64_T, MPI_SUM);
}
std::int64_t Comm::max(std::int64_t value) const {
  return reduced(*this, value, MPI_INT64_T, MPI_MAX);
}
void Comm::sum(std::span<std::int64_t> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), checked_int(values.size()), MPI_INT64_T, MPI_SUM,
                mpi(*this));
}
void Comm::sum(std::span<double> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), checked_int(values.size()), MPI_DOUBLE, MPI_SUM,
                mpi(*this));
}
void Comm::max(std::span<double> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), checked_int(values.size()), MPI_DOUBLE, MPI_MAX,
                mpi(*this));
}
std::int64_t Comm::exclusive_scan(std::int64_t value) const {
  std::int64_t before = 0;
  MPI_Exscan(&value, &before, 1, MPI_INT64_T, MPI_SUM, mpi(*this));
  return root() ? 0 : before;  // MPI leaves rank 0's result undefined
}

// Lengths first: ranks send different amounts, and a receiver must know them to arrange its buffer.
std::vector<std::byte> Comm::all_gather_bytes(std::span<const std::byte> mine) const {
  const int count = checked_int(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(size_));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, mpi(*this));
  const std::vector<int> offsets = offsets_of(counts);
  std::vector<std::byte> all(static_cast<std::size_t>(offsets.back()));
  MPI_Allgatherv(mine.data(), count, MPI_BYTE, all.data(), counts.data(), offsets.data(), MPI_BYTE,
                 mpi(*this));
  return all;
}

// Any rank may send to any. The result is in the order of ranks, whatever the order of arrival.
// A message may be longer than MPI's counts: it is sent in parts, which arrive in order.
std::vector<std::vector<std::byte>> Comm::exchange_bytes(
    const std::vector<std::span<const std::byte>>& out) const {
  const auto ranks = static_cast<std::size_t>(size_), self = static_cast<std::size_t>(rank_);
  require(out.size() == ranks, "exchange needs one list per rank");
  std::vector<std::int64_t> send_counts(ranks), receive_counts(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    send_counts[r] = r == self ? 0 : static_cast<std::int64_t>(out[r].size());
  // Only the counts go to every rank; after that only ranks with data for each other exchange
  // messages. With neighbours in space these are a handful of messages instead of ranks^2, over
  // which an MPI_Alltoallv would loop.
  MPI_Alltoall(send_counts.data(), 1, MPI_INT64_T, receive_counts.data(), 1, MPI_INT64_T,
               mpi(*this));
  std::vector<std::vector<std::byte>> in(ranks);
  std::vector<MPI_Request> requests;
  constexpr std::size_t longest = std::size_t{1} << 30;  // bytes of a part
  const auto for_parts = [&](std::size_t size, auto&& visit) {
    for (std::size_t begin = 0; begin < size; begin += longest)
      visit(begin, static_cast<int>(std::min(longest, size - begin)));
  };
  // Halo uses another tag: its messages may be in transit at the same time.
  constexpr int tag = 71;
  // Receives are posted before any send, so that no message has to wait in a buffer of MPI.
  for (std::size_t r = 0; r < ranks; ++r) {
    in[r].resize(static_cast<std::size_t>(receive_counts[r]));
    for_parts(in[r].size(), [&](std::size_t begin, int count) {
      MPI_Irecv(in[r].data() + begin, count, MPI_BYTE, static_cast<int>(r), tag, mpi(*this),
                &requests.emplace_back());
    });
  }
  for (std::size_t r = 0; r < ranks; ++r)
    for_parts(static_cast<std::size_t>(send_counts[r]), [&](std::size_t begin, int count) {
      MPI_Isend(out[r].data() + begin, count, MPI_BYTE, static_cast<int>(r), tag, mpi(*this),
                &requests.emplace_back());
    });
  MPI_Waitall(checked_int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return in;
}

// Length first, as it is known on rank 0 only.
std::string Comm::broadcast(const std::string& text) const {
  std::int64_t length = static_cast<std::int64_t>(text.size());
  MPI_Bcast(&length, 1, MPI_INT64_T, 0, mpi(*this));
  std::string result = root() ? text : std::string(static_cast<std::size_t>(length), ' ');
  MPI_Bcast(result.data(), checked_int(result.size()), MPI_CHAR, 0, mpi(*this));
  return result;
}

// A single integer reduction if there is no problem, which is nearly always the case; text is sent
// only otherwise. The maximum of size - rank identifies the lowest rank with a problem and is 0 if
// there is none. The lowest rank is chosen so that the message does not depend on timing.
std::string Comm::first_problem(const std::string& problem) const {
  const std::int64_t first = max(problem.empty() ? std::int64_t{0} : std::int64_t{size_ - rank_});
  if (first == 0) return "";
  const int speaker = size_ - static_cast<int>(first);
  std::int64_t length = static_cast<std::int64_t>(problem.size());
  MPI_Bcast(&length, 1, MPI_INT64_T, speaker, mpi(*this));
  std::string text =
      rank_ == speaker ? problem : std::string(static_cast<std::size_t>(length), ' ');
  MPI_Bcast(text.data(), checked_int(text.size()), MPI_CHAR, speaker, mpi(*this));
  return text;
}

void Comm::agree(const std::string& problem) const {
  const std::string named = problem.empty() ? "" : "rank " + std::to_string(rank_) + ": " + problem;
  if (const std::string first = first_problem(named); !first.empty()) throw RunError(first);
}

}  // namespace trackbed::par
