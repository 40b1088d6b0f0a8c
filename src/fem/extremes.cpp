// The quantities of extremes, listed once: fields and checkpoints visit the list. Another one is a
// line here and a larger `count`; checkpoints written before then have too few columns.
#include "extremes.hpp"

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

// Not a number is never less: the first value always enters.
void Extremes::take(std::size_t zone, const Vec6& stress) {
  const Vec3 values_of = principal(stress).value;
  for (std::size_t q = 0; q < count; ++q) {
    const Quantity& quantity = quantities()[q];
    const double now = quantity.of(stress, values_of);
    double& so_far = values[zone * count + q];
    if (!(quantity.sign * now <= quantity.sign * so_far)) so_far = now;
  }
}

}  // namespace trackbed::fem
