// Apart from `fill`, so that a check of a deck need not know the particles' code.
#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace trackbed::bed {

// Each number is drawn once, whatever the order: one look at all of them finds the lightest stone
// to the bit.
// Cost: a draw per stone on every rank, and the placing of a share of them.
Stones stones_of(const par::Comm& comm, const BedParameters& parameters,
                 const dem::Domain& domain) {
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const int power = domain.dimension == Dimension::plane ? 2 : 3;
  const Columns columns(parameters, domain, mix);
  Stones stones{.count = columns.stones(),
                .smallest_volume = std::numeric_limits<double>::infinity()};
  for (std::int64_t k = 0; k < stones.count; ++k) {
    const Draw draw =
        mix.draw(static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(stones.count));
    const double volume =
        mix.templates()[static_cast<std::size_t>(draw.shape)].volume * std::pow(draw.scale, power);
    stones.smallest_volume = std::min(stones.smallest_volume, volume);
    stones.largest_bound = std::max(stones.largest_bound, mix.bound(draw));
    stones.longest = std::max(stones.longest, mix.extent(draw));
  }
  // Placed and thrown away: whether they fit is to be known before anything runs.
  const auto [begin, count] =
      io::share(static_cast<std::size_t>(columns.count()), comm.rank(), comm.size());
  for (std::size_t c = begin; c < begin + count; ++c) {
    std::vector<dem::NewParticle> placed;
    stones.top = std::max(stones.top, columns.build(static_cast<std::int64_t>(c), placed));
  }
  stones.top = comm.max(stones.top);
  return stones;
}

}  // namespace trackbed::bed
