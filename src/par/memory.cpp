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

// The least limit of the control groups (second version) around this process, which containers and
// queues set; a group without a limit has a word instead of the number.
double limit_of_groups() {
  const std::string root = "/sys/fs/cgroup";
  std::string group;
  std::ifstream own("/proc/self/cgroup");
  for (std::string line; std::getline(own, line);)
    if (line.starts_with("0::")) group = line.substr(3);
  double least = std::numeric_limits<double>::infinity(), bytes = 0;
  for (;;) {
    if (std::ifstream file(root + group + "/memory.max"); file >> bytes)
      least = std::min(least, bytes);
    const auto parent = group.rfind('/');
    if (group.empty() || parent == std::string::npos) return least;
    group.resize(parent);
  }
}

double memory_of_node() {
  const auto pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  return std::min(pages * static_cast<double>(sysconf(_SC_PAGESIZE)), limit_of_groups());
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
