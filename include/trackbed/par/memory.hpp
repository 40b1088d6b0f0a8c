// Memory of the machines on which the ranks run.
#pragma once

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

// Bytes for each rank, of the node that has least: its physical memory, or what its control groups
// allow, over its ranks. Other programs are not seen. Collective.
double memory_of_rank(const Comm& comm);

// Throws InputError if a rank needs more bytes than it can have: otherwise the system kills the run
// without a word. `what` needs them, as in "the bed has 1e+12 stones"; `remedy` may help.
// Collective; `bytes` of the rank that needs most, the same on all.
void require_memory(const Comm& comm, double bytes, const std::string& what,
                    const std::string& remedy);

}  // namespace trackbed::par
