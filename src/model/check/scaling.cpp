// The time of a sub-step on N ranks is estimated as
//   work of the busiest rank + neighbours latency + bytes/bandwidth + reduction log2(N),
// the last for the decision about new lists, which all ranks take together. Work is counted by the
// load balance; ground, coupling and output are left out.
#include "model/check/scaling.hpp"

#include <fmt/format.h>

#include <cmath>

namespace trackbed::model {

namespace {

// Of a usual network between nodes (InfiniBand): s for a message, bytes/s of a rank, s for each
// doubling of ranks in a reduction. Assumed, not measured.
constexpr double latency = 2e-6, bandwidth = 2e9, reduction = 2e-6;

double messages(const dem::Decomposition& d, int ranks) {
  if (ranks == 1) return 0;
  return d.neighbours_most * latency + d.bytes_most / bandwidth +
         reduction * std::log2(static_cast<double>(ranks));
}

}  // namespace

std::vector<std::string> scaling_of(World& world, const std::vector<int>& ranks) {
  world.particles.make_lists();
  const double alone = 1e-9 * world.particles.decomposition(1).work_most;
  std::vector<std::string> lines{fmt::format(
      "ranks  stones of a rank  work us  over mean  ghosts/own  neighbours  kB/sub-step "
      " messages us  speed-up  (of stones alone; messages of {:g} us, {:g} GB/s, {:g} "
      "us for a doubling of ranks are assumed)",
      1e6 * latency, 1e-9 * bandwidth, 1e6 * reduction)};
  for (const int n : ranks) {
    const dem::Decomposition d = world.particles.decomposition(n);
    const double work = 1e-9 * d.work_most, wait = messages(d, n);
    lines.push_back(fmt::format(
        "{:5}  {:16.0f}  {:7.1f}  {:9.2f}  {:10.2f}  {:10.1f}  {:11.1f}  {:11.1f}  {:8.1f}", n,
        d.particles_mean, 1e6 * work, d.work_most / d.work_mean,
        d.ghosts_mean / std::max(1.0, d.particles_mean), d.neighbours_mean, 1e-3 * d.bytes_mean,
        1e6 * wait, alone / (work + wait)));
  }
  return lines;
}

}  // namespace trackbed::model
