// Where stones start: in columns as wide as the largest stone, each stone in a circle or sphere of
// its own above the last one. Stones of a column lie as close as their bounds, which keeps the
// fall short; ids run along x, then y, then up, so neighbours have close ids.
#pragma once

#include <vector>

#include "mix.hpp"

namespace trackbed::bed {

class Columns {
 public:
  // Throws InputError if the bed is narrower than a stone.
  Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix);

  std::int64_t stones() const { return stones_; }
  std::int64_t count() const { return along_ * across_; }
  // Adds the stones of column `c` to `to`, shapes numbered from 0; returns the height it reaches,
  // m.
  double build(std::int64_t c, std::vector<dem::NewParticle>& to) const;

 private:
  double place(std::int64_t i, const Vec3& foot, std::vector<dem::NewParticle>& to) const;

  const Mix& mix_;
  Dimension dimension_;
  std::uint64_t seed_;
  std::int64_t stones_ = 0, along_ = 1, across_ = 1;
  Vec3 low_ = Vec3::Zero(), size_ = Vec3::Zero();  // m, corner and size of the first column
};

// A random order of 0 .. count - 1: the place of `i`, found without knowing the others'.
std::uint64_t shuffled(std::uint64_t i, std::uint64_t count, std::uint64_t seed);

}  // namespace trackbed::bed
