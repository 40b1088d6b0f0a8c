// The quantities of extremes, listed once: fields and checkpoints visit the list. A further
// quantity needs a line here and a larger `count`; earlier checkpoints then have too few columns.
#include "fem/ground/extremes.hpp"

namespace trackbed::fem {

const std::array<Extremes::Quantity, Extremes::count>& Extremes::quantities() {
  static const std::array<Quantity, count> list{{
      {"largest principal stress", "most tension", 1,
       [](const Vec6&, const Vec3& principal) { return principal.x(); }},
      {"least principal stress", "most compression", -1,
       [](const Vec6&, const Vec3& principal) { return principal.z(); }},
      {"largest shear stress", "half the difference of principal stresses", 1,
       [](const Vec6&, const Vec3& principal) { return 0.5 * (principal.x() - principal.z()); }},
      {"largest vertical stress", "tension positive", 1,
       [](const Vec6& stress, const Vec3&) { return stress(2); }},
      {"least vertical stress", "most compression", -1,
       [](const Vec6& stress, const Vec3&) { return stress(2); }},
  }};
  return list;
}

// NaN compares false: the first value is always taken.
void Extremes::take(std::size_t element, const Vec6& stress) {
  const Vec3 values_of = principal(stress).value;
  for (std::size_t q = 0; q < count; ++q) {
    const Quantity& quantity = quantities()[q];
    const double now = quantity.of(stress, values_of);
    double& extreme = values[element * count + q];
    if (!(quantity.sign * now <= quantity.sign * extreme)) extreme = now;
  }
}

}  // namespace trackbed::fem
