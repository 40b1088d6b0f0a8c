// Separate from `fill`, so that checking a deck does not need the code of the particles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"
#include "trackbed/par/memory.hpp"

namespace trackbed::bed {

namespace {

constexpr double bytes_of_stone = 500;  // a ball without contacts; most stones need far more

}  // namespace

// Each size is drawn once, in any order, so the loop over all of them gives the lightest stone
// exactly.
// Cost: a draw per stone on every rank, and the placement of a fraction of them.
Stones stones_of(const par::Comm& comm, const BedParameters& parameters,
                 const dem::Domain& domain) {
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const int power = domain.dimension == Dimension::plane ? 2 : 3;
  const Columns columns(parameters, domain, mix);
  Stones stones{.count = columns.stones(),
                .smallest_volume = std::numeric_limits<double>::infinity()};
  par::require_memory(
      comm, bytes_of_stone * static_cast<double>(stones.count) / comm.size(),
      fmt::format("{} has {:.3g} stones", parameters.section, static_cast<double>(stones.count)),
      "are lengths in m and sieve sizes in mm? Otherwise use larger stones, a "
      "smaller bed or more nodes");
  for (std::int64_t k = 0; k < stones.count; ++k) {
    const Draw draw =
        mix.draw(static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(stones.count));
    const double volume =
        mix.templates()[static_cast<std::size_t>(draw.shape)].volume * std::pow(draw.scale, power);
    stones.smallest_volume = std::min(stones.smallest_volume, volume);
    stones.largest_bound = std::max(stones.largest_bound, mix.bound(draw));
    stones.longest = std::max(stones.longest, mix.extent(draw));
  }
  // Placed and discarded, to check that they fit before the run.
  const auto [begin, count] =
      io::row_range(static_cast<std::size_t>(columns.count()), comm.rank(), comm.size());
  for (std::size_t c = begin; c < begin + count; ++c) {
    std::vector<dem::NewParticle> placed;
    stones.top = std::max(stones.top, columns.build(static_cast<std::int64_t>(c), placed));
  }
  stones.top = comm.max(stones.top);
  return stones;
}

}  // namespace trackbed::bed
