// See grading.hpp for the two distributions; both are tables of cumulative fractions per sieve.
//
// Cost: a search in a table of a few sieves per draw.
#include "grading.hpp"

#include <algorithm>
#include <cmath>

#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

namespace {

// Class [k, k + 1] of an increasing table that contains `value`. Empty classes are skipped, also at
// the coarse end: the largest value lies at the end of the last class that has stones.
std::size_t class_of(const std::vector<double>& table, double value) {
  const auto found = value < table.back()
                         ? std::upper_bound(table.begin(), table.end(), value)
                         : std::lower_bound(table.begin(), table.end(), table.back());
  const auto above = found - table.begin();
  const auto last = static_cast<std::ptrdiff_t>(table.size()) - 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above, 1, last)) - 1;
}

}  // namespace

const GradingLimits& limits_of(GradingKind kind) {
  static const GradingLimits none,
      en13450_a{{22.4, 31.5, 40, 50, 63}, {0, 1, 30, 70, 100}, {3, 25, 65, 99, 100}},
      china_first{{16, 25, 35.5, 45, 56, 63}, {0, 5, 25, 55, 92, 97}, {5, 15, 40, 75, 97, 100}},
      as2758_60{{13.2, 19, 26.5, 37.5, 53, 63}, {0, 0, 0, 20, 85, 100}, {2, 5, 20, 65, 100, 100}};
  switch (kind) {
    case GradingKind::custom:
      return none;
    case GradingKind::en13450_a:
    case GradingKind::china_special:
      return en13450_a;
    case GradingKind::china_first:
      return china_first;
    case GradingKind::as2758_60:
      return as2758_60;
  }
  return none;
}

//   N_k = p_k (a^-D - b^-D)/(D log(b/a)),   p_k = P(b) - P(a)
// per unit of mass of s^D; sieves in m, P from 0 to 1. From dN = dP/s^D with dP = p_k
// dlog(s)/log(b/a).
Grading::Grading(const std::vector<double>& sieve, const std::vector<double>& passing,
                 int dimension)
    : sieve_(sieve), mass_(passing), stones_(sieve.size(), 0.0), power_(dimension) {
  for (double& fraction : mass_) fraction /= 100;
  for (std::size_t k = 0; k + 1 < sieve.size(); ++k) {
    const double a = sieve[k], b = sieve[k + 1];
    const double per_mass =
        (std::pow(a, -power_) - std::pow(b, -power_)) / (power_ * std::log(b / a));
    stones_[k + 1] = stones_[k] + (mass_[k + 1] - mass_[k]) * per_mass;
  }
}

//   s = a (b/a)^part, since P is linear in log(s).
double Grading::by_mass(double fraction) const {
  const std::size_t k = class_of(mass_, fraction);
  // Clamped, since rounding of the fractions may lead slightly beyond the class.
  const double part = std::clamp((fraction - mass_[k]) / (mass_[k + 1] - mass_[k]), 0.0, 1.0);
  return sieve_[k] * std::pow(sieve_[k + 1] / sieve_[k], part);
}

double Grading::by_number(double fraction) const {
  const double wanted = fraction * stones_.back();
  const std::size_t k = class_of(stones_, wanted);
  const double part = std::clamp((wanted - stones_[k]) / (stones_[k + 1] - stones_[k]), 0.0, 1.0);
  // The inverse of the number law within a class: d^-p decreases linearly from a^-p to b^-p.
  const double a = std::pow(sieve_[k], -power_), b = std::pow(sieve_[k + 1], -power_);
  return std::pow(a - part * (a - b), -1 / power_);
}

}  // namespace trackbed::bed
