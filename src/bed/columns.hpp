// Where stones start: in columns, each stone in a circle or sphere of its own. In a plane a column
// is as wide as the largest stone and the next stone lies above the last one; in space it is wider
// and the next stone lies as low as a few tries find room (drop and stick), which keeps the fall
// short. Ids run along x, then y, then up, so neighbours have close ids.
#pragma once

#include <utility>
#include <vector>

#include "mix.hpp"

namespace trackbed::bed {

// Keeps a reference to `mix`, which must outlive it. Local: every rank holds the same.
class Columns {
 public:
  // For stones of this share of their size. Throws InputError if the bed is narrower than a stone.
  Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix,
          double share = 1);

  std::int64_t stones() const { return stones_; }
  std::int64_t count() const { return along_ * across_; }
  // Adds the stones of column `c` to `to`, shapes numbered from 0; returns the height it reaches,
  // m.
  double build(std::int64_t c, std::vector<dem::NewParticle>& to) const;

 private:
  // Stone i, not yet placed; and where its centre goes, from the foot of its column.
  dem::NewParticle make(std::int64_t i) const;
  Vec3 on_top(std::int64_t i, double room, double top) const;
  Vec3 lowest(std::int64_t i, double room, const std::vector<geom::Sphere>& balls) const;

  std::pair<double, double> in_circle(std::int64_t i, double room, std::uint64_t seed) const;

  const Mix& mix_;
  Dimension dimension_;
  std::uint64_t seed_;
  double share_;
  std::int64_t stones_ = 0, along_ = 1, across_ = 1;
  double clear_ = 0;  // m, radius free of the walls of a cylinder; 0: a box
  Vec3 low_ = Vec3::Zero(), size_ = Vec3::Zero();  // m, corner and size of the first column
};

// A random order of 0 .. count - 1: the place of `i`, found without knowing the others'.
std::uint64_t shuffled(std::uint64_t i, std::uint64_t count, std::uint64_t seed);

}  // namespace trackbed::bed
