// Initial positions of stones: in columns, each stone within its bounding circle or sphere. In a
// plane a column is as wide as the largest stone and each stone lies above the previous one; in
// space it is wider and the next stone takes the lowest of a few trial positions (drop and stick),
// which shortens the fall. Ids increase along x, then y, then upwards, so that neighbours have
// similar ids.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "mix.hpp"

namespace trackbed::bed {

// Spheres that lie on each other or on the floor z = 0, in the order in which they were dropped.
class Heap {
 public:
  // On a floor from (0, 0) to `size`, m, divided into `cells` x `cells` cells for the search.
  Heap(const Vec3& size, std::int64_t cells);
  void add(const geom::Sphere& ball);
  // z at which a sphere of radius r, dropped at (x, y), touches those below it or the floor. If
  // this is not below `limit`, any value that is not below it.
  double height_on(double x, double y, double r, double limit) const;

 private:
  // Balls above a cell of the floor.
  struct Cell {
    std::vector<double> x, y, z, radius;  // m
    std::vector<double> highest;          // m, top of any of them up to this one
  };
  // Calls `visit` with the number of each cell below a ball.
  template <class Visit>
  void cells_below(double x, double y, double radius, Visit visit) const;
  static double height_on(const Cell& cell, double x, double y, double r, double limit,
                          double height);

  std::array<double, 2> width_;  // m, of a cell
  std::int64_t cells_;           // along each side
  std::vector<Cell> all_;
};

// Keeps a reference to `mix`, which must outlive it. Local: every rank holds the same.
class Columns {
 public:
  // For stones scaled by `size_factor`. Throws InputError if the bed is narrower than a stone.
  Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix,
          double size_factor = 1);

  std::int64_t stones() const { return stones_; }
  std::int64_t count() const { return along_ * across_; }
  // Adds the stones of column `c` to `to`, shapes numbered from 0; returns the height it reaches,
  // m.
  double build(std::int64_t c, std::vector<dem::NewParticle>& to) const;

 private:
  // Stone i without a position; and the position of its centre relative to the foot of its column.
  dem::NewParticle make(std::int64_t i) const;
  Vec3 on_top(std::int64_t i, double clearance, double top) const;
  Vec3 lowest(std::int64_t i, double clearance, const Heap& heap) const;

  std::pair<double, double> in_circle(std::int64_t i, double clearance, std::uint64_t seed) const;

  const Mix& mix_;
  Dimension dimension_;
  std::uint64_t seed_;
  double size_factor_;
  std::int64_t stones_ = 0, along_ = 1, across_ = 1;
  double clear_ = 0;  // m, radius free of the walls of a cylinder; 0: a box
  Vec3 low_ = Vec3::Zero(), size_ = Vec3::Zero();  // m, corner and size of the first column
};

// m, height of the highest of some loose columns, evenly spread: at most 1024 with about a million
// stones. A higher one among the others only lets growing stones begin a little larger than meant,
// and is found when they are placed. Collective.
double height_of(const par::Comm& comm, const Columns& columns);

// A pseudo-random permutation of 0 .. count - 1: the image of `i`, computed without the others.
std::uint64_t shuffled(std::uint64_t i, std::uint64_t count, std::uint64_t seed);

}  // namespace trackbed::bed
