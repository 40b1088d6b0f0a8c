#include "trackbed/par/memory.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "trackbed/core/error.hpp"
#include "trackbed/par/processors.hpp"

namespace trackbed::par {

namespace {

// Of the second version of control groups, which containers and queues set; a group without a limit
// has a word instead of the number.
double limit_of_group() {
  std::ifstream file("/sys/fs/cgroup/memory.max");
  double bytes = 0;
  return file >> bytes ? bytes : std::numeric_limits<double>::infinity();
}

double memory_of_node() {
  const auto pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  return std::min(pages * static_cast<double>(sysconf(_SC_PAGESIZE)), limit_of_group());
}

}  // namespace

double memory_of_rank(const Comm& comm) { return comm.min(memory_of_node() / ranks_on_node(comm)); }

void require_memory(const Comm& comm, double bytes, const std::string& what,
                    const std::string& remedy) {
  const double has = memory_of_rank(comm);
  if (bytes <= has) return;
  throw InputError({fmt::format(
      "{} and needs at least {:.3g} GB on each of {} rank{}, but this machine has {:.3g} GB for "
      "each; {}",
      what, 1e-9 * bytes, comm.size(), comm.size() > 1 ? "s" : "", 1e-9 * has, remedy)});
}

}  // namespace trackbed::par
