// State of the breakage of corners; the operations are in breakage.cpp, break_off.cpp,
// fragment_growth.cpp and breakage_file.cpp.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <unordered_map>
#include <vector>

#include "dem/state/state.hpp"
#include "trackbed/dem/breakage.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::dem {

inline double ball_volume(double radius) {
  return 4 * std::numbers::pi / 3 * radius * radius * radius;
}
inline double radius_of(double volume) { return std::cbrt(3 * volume / (4 * std::numbers::pi)); }

// The longest growth of a fragment at a time over the radius of the smallest one. Lists must hold
// what two of them may reach, and some motion.
inline constexpr double longest_growth = 0.1, growth_in_lists = 4 * longest_growth;

// A pebble that was loaded beyond its strength, of an own stone. Members have 8 bytes: ranks
// exchange them as they are in memory.
struct Crack {
  std::int64_t stone, pebble;  // its number in the unbroken stone
  std::int64_t shape;          // of the stone, with its present pieces
  double scale, density;       // of the stone; kg/m^3
  double force, overlap;       // N, m: of the contact with the largest force
  double energy;               // J, of its normal spring
};

// What becomes of a shape when it loses a pebble.
struct Loss {
  std::int64_t shape = 0;            // number of the remainder's template
  geom::Remainder rest;              // at unit scale
  Vec3 out = Vec3::Zero();           // unit vector from the pebble's centre to its lost part
  geom::Sphere pebble;               // m at unit scale
  std::vector<geom::Sphere> beside;  // the other balls, m at unit scale
};

// A stone while its pebbles break off: present template, and what its former pieces have become,
// -1: lost; none: all are there.
struct Changed {
  std::int64_t shape;
  std::vector<std::int64_t> pieces;
};

// Where a fragment begins, at unit scale in the axes of the whole stone.
struct Birth {
  Vec3 at;        // m
  double radius;  // m
};

// A fragment that has not its final size yet, and its neighbours. Of a ghost nothing is listed:
// its owner decides how far it grows.
struct GrowingFragment {
  std::size_t body;
  double radius;  // m, when the lists were made
  struct Neighbour {
    std::int32_t piece;
    Vec4 shift;  // m, added to its position
  };
  std::vector<Neighbour> beside;
  std::vector<std::size_t> approaches;  // to surfaces
};

struct Breaking {
  BreakageParameters parameters;  // not part of the state
  int material = -1;
  int ball = -1;  // number of the template of fragments
  // State: whether stones break now, the least mass of a fragment (kg), the next id, what broke.
  bool active = false;
  double least_mass = 0;
  double least_radius = 0, largest_radius = 0;  // m, of fragments; of all stones, whatever breaks
  Id next = -1;
  double elapsed = 0;         // s
  std::vector<Crack> cracks;  // of the last window, which break at the begin of the next one
  std::int64_t pending = 0;   // cracks of all ranks
  std::vector<Break> breaks;  // by this rank
  BreakTotals totals;
  // Derived
  std::vector<double> strength;          // N, of each piece in the lists; infinite: it is not weak
  std::vector<GrowingFragment> growing;  // in the lists, ghosts included
  // m, of the radius of a fragment, at most: since the lists were made, and at the next time.
  double grown_since_rebuild = 0, next_growth = 0;
  std::map<std::pair<std::int64_t, std::size_t>, Loss> losses;  // by shape and piece
};

}  // namespace trackbed::dem
