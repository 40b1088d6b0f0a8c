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

// Sizes are drawn in ascending order and shapes in turn, so that the lightest and the largest stone
// of each shape are among the first and the last draws; of a library, whose shapes are drawn one
// after the other, each draw is looked at.
// Cost: the placement of a fraction of the columns, of large beds of some of them.
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
  const auto look_at = [&](std::int64_t k) {
    const Draw draw =
        mix.draw(static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(stones.count));
    const double volume =
        mix.templates()[static_cast<std::size_t>(draw.shape)].volume * std::pow(draw.scale, power);
    stones.smallest_volume = std::min(stones.smallest_volume, volume);
    stones.largest_bound = std::max(stones.largest_bound, mix.bound(draw));
    stones.longest = std::max(stones.longest, mix.extent(draw));
  };
  const auto shapes = static_cast<std::int64_t>(mix.templates().size());
  const std::int64_t half = (stones.count + 1) / 2;
  const std::int64_t ends = mix.ascends() ? std::min(shapes, half) : half;
  for (std::int64_t k = 0; k < ends; ++k) look_at(k), look_at(stones.count - 1 - k);
  // Placed and discarded, to check that they fit before the run.
  stones.top = height_of(comm, columns);
  return stones;
}

}  // namespace trackbed::bed
