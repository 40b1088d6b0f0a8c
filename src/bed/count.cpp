// Apart from `fill`, so that a check of a deck need not know the particles' code.
#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace trackbed::bed {

// Each number is drawn once, whatever the order: one look at all of them finds the lightest stone
// to the bit.
// Cost: a draw per stone, no placing. Every rank looks at all.
Stones stones_of(const par::Comm& comm, const BedParameters& parameters,
                 const dem::Domain& domain) {
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const int power = domain.dimension == Dimension::plane ? 2 : 3;
  Stones stones{.count = Columns(parameters, domain, mix).stones(),
                .smallest_volume = std::numeric_limits<double>::infinity()};
  for (std::int64_t k = 0; k < stones.count; ++k) {
    const Draw draw =
        mix.draw(static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(stones.count));
    const double volume =
        mix.templates()[static_cast<std::size_t>(draw.shape)].volume * std::pow(draw.scale, power);
    stones.smallest_volume = std::min(stones.smallest_volume, volume);
    stones.largest_bound = std::max(stones.largest_bound, mix.bound(draw));
  }
  return stones;
}

}  // namespace trackbed::bed
