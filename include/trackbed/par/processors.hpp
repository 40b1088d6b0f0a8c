// Processors that the ranks of a node may use.
#pragma once

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

// The node with the most ranks per processor.
struct Processors {
  int ranks = 1;
  int processors = 1;  // on which at least one of these ranks may run
  // Ranks that wait for messages then hinder those that compute.
  bool too_few() const { return ranks > processors; }
};

// By the affinities of the processes, which mpirun sets (--bind-to). Other programs on the same
// processors are not seen. Collective.
Processors processors_of(const Comm& comm);

int ranks_on_node(const Comm& comm);  // of this rank; collective

}  // namespace trackbed::par
