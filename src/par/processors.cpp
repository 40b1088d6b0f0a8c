// Ranks of a node are those that can share memory.
#include "trackbed/par/processors.hpp"

#include <sched.h>

#include <array>
#include <bit>
#include <cstdint>

#include "trackbed/par/mpi.hpp"

namespace trackbed::par {

namespace {

using Bits = std::array<std::uint64_t, CPU_SETSIZE / 64>;  // one for each processor

// Of this process; all if the system does not tell.
Bits affinity() {
  cpu_set_t set;
  Bits bits{};
  if (sched_getaffinity(0, sizeof set, &set) != 0) {
    bits.fill(~std::uint64_t{0});
    return bits;
  }
  for (std::size_t k = 0; k < CPU_SETSIZE; ++k)
    if (CPU_ISSET(k, &set)) bits[k / 64] |= std::uint64_t{1} << (k % 64);
  return bits;
}

// Of the node of this rank.
Processors on_node(const Comm& comm) {
  MPI_Comm node = MPI_COMM_NULL;
  MPI_Comm_split_type(mpi(comm), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  Bits bits = affinity();
  MPI_Allreduce(MPI_IN_PLACE, bits.data(), static_cast<int>(bits.size()), MPI_UINT64_T, MPI_BOR,
                node);
  Processors here{0, 0};
  MPI_Comm_size(node, &here.ranks);
  MPI_Comm_free(&node);
  for (const std::uint64_t part : bits) here.processors += std::popcount(part);
  return here;
}

}  // namespace

int ranks_on_node(const Comm& comm) { return on_node(comm).ranks; }

Processors processors_of(const Comm& comm) {
  const Processors mine = on_node(comm);
  Processors worst = mine;
  for (const Processors& other : comm.all_gather(std::span<const Processors>(&mine, 1)))
    if (other.ranks * worst.processors > worst.ranks * other.processors) worst = other;
  return worst;
}

}  // namespace trackbed::par
