// The time of a sub-step on N ranks is estimated as
//   work of the busiest rank + neighbours latency + bytes/bandwidth + reduction log2(N),
// neighbours and bytes of the ranks that have most, the last for the decision about new lists,
// which all ranks take together. Work is counted by the load balance; ground, coupling and output
// are left out.
#include "model/check/scaling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/core/error.hpp"

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

// The load balance counts work in proportion; its unit follows from the estimate for one rank.
std::vector<std::string> scaling_of(World& world, const std::vector<int>& ranks, double step_time) {
  world.particles.make_lists();
  const dem::Decomposition whole = world.particles.decomposition(1);
  const double alone = step_time * whole.particles_mean, unit = alone / whole.work_mean;
  // Of a stone with its contacts, as they are now.
  const double bytes = static_cast<double>(world.particles.memory().total()) / whole.particles_mean;
  std::vector<std::string> lines{
      fmt::format("of the stones as they are laid, in a sub-step (assumed: {:g} us for a "
                  "neighbour, {:g} GB/s, {:g} us for a doubling of ranks):",
                  1e6 * latency, 1e-9 * bandwidth, 1e6 * reduction),
      "ranks  stones of a rank  work us  over mean  ghosts/own  neighbours  received kB  messages "
      "us  speed-up  MB"};
  for (const int n : ranks) {
    if (n > whole.particles_mean)
      throw InputError(
          {fmt::format("--ranks {}: the deck has only {:.0f} stones", n, whole.particles_mean)});
    const dem::Decomposition d = world.particles.decomposition(n);
    const double work = unit * d.work_most, wait = messages(d, n);
    lines.push_back(fmt::format(
        "{:5}  {:16.0f}  {:7.1f}  {:9.2f}  {:10.2f}  {:10.0f}  {:11.1f}  {:11.1f}  {:8.1f}  {:.1f}",
        n, d.particles_mean, 1e6 * work, d.work_most / d.work_mean,
        d.ghosts_mean / std::max(1.0, d.particles_mean), d.neighbours_most, 1e-3 * d.bytes_most,
        1e6 * wait, alone / (work + wait), 1e-6 * bytes * (d.particles_most + d.ghosts_most)));
  }
  return lines;
}

}  // namespace trackbed::model
