// Stones for the particles, each rank its share.
#include <fmt/format.h>

#include <algorithm>

#include "columns.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::bed {

// Every rank builds an even share of the columns; the particles then go to their owners.
double fill(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
            int material) {
  const Mix mix(parameters, particles.domain().dimension);
  const Columns columns(parameters, particles.domain(), mix);
  const auto [begin, count] =
      io::share(static_cast<std::size_t>(columns.count()), comm.rank(), comm.size());
  std::vector<dem::NewParticle> mine;
  double top = 0;
  for (std::size_t c = begin; c < begin + count; ++c)
    top = std::max(top, columns.build(static_cast<std::int64_t>(c), mine));
  top = comm.max(top);
  if (top > particles.domain().high.z())
    throw InputError(
        {fmt::format("bed.height: the loose stones reach up to {:.3g} m, beyond the top of the "
                     "domain ({:.3g} m)",
                     top, particles.domain().high.z())});
  std::vector<int> numbers;
  for (const dem::Template& shape : mix.templates())
    numbers.push_back(particles.add_template(shape));
  for (dem::NewParticle& stone : mine) {
    stone.shape = numbers[static_cast<std::size_t>(stone.shape)];
    stone.material = material;
  }
  particles.add(mine);
  return top;
}

}  // namespace trackbed::bed
