// Apart from `fill`, so that a check of a deck need not know the particles' code.
#include "columns.hpp"

namespace trackbed::bed {

std::int64_t count(const BedParameters& parameters, const dem::Domain& domain) {
  const Mix mix(parameters, domain.dimension);
  return Columns(parameters, domain, mix).stones();
}

}  // namespace trackbed::bed
