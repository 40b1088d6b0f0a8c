// State of breakage. Operations on clumps: breakage.cpp, break_off.cpp, fragment_growth.cpp; on
// stones with corners: overload.cpp, cut_off.cpp; checkpoint: breakage_file.cpp.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <set>
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

// [ln(1/P)]^(1/modulus) with the P that belongs to seed and key.
double weibull_factor(std::uint64_t seed, std::uint64_t key, double modulus);

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

// A stone with corners that is cut by the plane normal . x = offset, in its axes and at unit scale,
// or that wears. Members have 8 bytes, as above.
struct Cut {
  std::int64_t stone, kind;  // kind: a BreakKind
  std::int64_t shape;        // of the stone
  double scale, density;     // of the stone; kg/m^3
  double normal[3], offset;  // unit length; m, of wear the lost volume, m^3
  double size[2];            // of the parts below and above, over that which the cut leaves
  double force, stress;      // N, largest of a contact; Pa, that reached the strength
  double energy;             // J, of the contacts that are released
};

// A contact of a stone, in its axes and at unit scale.
struct ContactLoad {
  Vec3 arm, out;           // m, from the centre of mass; unit length, out of the stone
  Vec3 force;              // N, on the stone
  double overlap, energy;  // m, J
};

// The parts below and above its plane; none: hardly any volume, or the corner or dust that becomes
// fines.
std::array<std::optional<geom::StonePart>, 2> parts_of(const geom::Template& whole, const Cut& cut);

// What a cut makes of a stone.
struct NewPart {
  geom::StonePart of;
  std::int64_t shape = -1;  // number of its template
  double size = 1;          // as in Cut
  Id id = -1;
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
  // Of the last window, which break at the begin of the next one; their number on all ranks.
  std::vector<Crack> cracks;
  std::vector<Cut> cuts;
  std::int64_t pending = 0;
  std::vector<Break> breaks;  // by this rank
  BreakTotals totals;
  std::set<std::int64_t> single;  // numbers of templates that only one stone can have
  std::int64_t waiting() const { return std::ssize(cracks) + std::ssize(cuts); }
  // Derived
  std::vector<double> strength;          // N, of each piece in the lists; infinite: it is not weak
  std::vector<GrowingFragment> growing;  // in the lists, ghosts included
  // m, of the radius of a fragment, at most: since the lists were made, and at the next time.
  double grown_since_rebuild = 0, next_growth = 0;
  std::map<std::pair<std::int64_t, std::size_t>, Loss> losses;  // by shape and piece
};

}  // namespace trackbed::dem
