// Pieces that may touch before the next rebuild, and the history of those in contact.
//
// Rows run over pieces in the order of (particle id, piece), entries of a row in the same order and
// only to higher ids. That order is the same on every rank, so each particle sums its forces in the
// same order wherever it is computed; entries that are not in contact add nothing. A pair of two
// ghosts is left out: it is computed by its owners.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "dem/law/laws.hpp"
#include "dem/search/grid.hpp"
#include "dem/shape/mesh.hpp"
#include "dem/shape/stone_surface.hpp"
#include "dem/state/state.hpp"

namespace trackbed::dem {

// Pieces of all local particles (own and ghosts) in space.
struct Pieces {
  std::vector<Vec4> x;  // m, centre; w: radius of the ball around it
  std::vector<std::int32_t> body;
  std::vector<std::size_t> begin;  // of each particle; one more at the end
  // Only if some shape has a piece with several corners:
  std::vector<std::uint32_t> core;   // of each piece: its number in `Shapes`
  std::vector<double> rounding;      // m
  std::vector<Vec4> turns;           // three of each particle: columns of scale times rotation
  std::vector<Vec4> last_x, last_q;  // poses of the particles at the last `place`
  std::vector<double> path;          // m, bound of a particle's path since `lay_out`, any point
  std::vector<double> pace;          // m, in the last sub-step
  std::vector<double> last_path;     // m, at the last `place`
};
void lay_out(const State& state, const Shapes& shapes, Pieces& pieces);  // sizes, bodies, radii
void place(const State& state, const Shapes& shapes, Pieces& pieces);    // all of them
// Pieces without corners, in ascending order; the others keep their former places.
void place(const State& state, const Shapes& shapes, std::span<const std::int32_t> wanted,
           Pieces& pieces);
// Appends the corners of a piece in space, m from the particle's centre of mass.
void append_corners(const Shapes& shapes, const Pieces& pieces, std::size_t piece,
                    std::vector<Vec4>& corners);

// Eight bytes: the list is read in full in each sub-step. The shift is a number and not a vector,
// since there are few different ones.
struct Entry {
  std::int32_t piece;   // j
  std::uint16_t shift;  // number of the periodic shift added to x_j - x_i
  std::uint8_t law;
  std::uint8_t touching;
};

struct Row {
  std::int32_t piece;  // i
  std::uint32_t begin, end;
};

struct PairList {
  std::vector<Row> rows;
  std::vector<Entry> entries;
  std::vector<Vec4> xi;      // m, history; w: sqrt of the effective mass
  std::vector<Vec4> roll;    // m, history; empty if no law resists rolling
  std::vector<double> size;  // `size` of History; empty if no law is Hertz's
  std::vector<Vec4> shifts;  // m, [0] is zero
  void clear() {
    rows.clear(), entries.clear(), xi.clear(), roll.clear(), size.clear();
    shifts.assign(1, Vec4{});
  }
  // Of an entry that is not in contact any more.
  void forget(std::uint32_t e) {
    entries[e].touching = 0;
    xi[e].set(Vec3::Zero());
    if (!roll.empty()) roll[e] = {};
    if (!size.empty()) size[e] = 0;
  }
};

// Pairs with a piece of several corners (stones.hpp), in a separate list: their contacts are found
// in another way and cost many times as much.
struct StoneList : PairList {
  // x: rad, relative rotation about the normal, cut by friction; y, z: `size` and `ring` of History
  std::vector<Vec4> turn;
  void clear() { PairList::clear(), turn.clear(); }
  void forget(std::uint32_t e) { PairList::forget(e), turn[e] = {}; }
};

// Where the centre of a ball was while it did not touch a surface, m, beside the piece; and the sum
// of the distance from there and of the surface's path until then: before centre and surface have
// moved as far, less the radius, they cannot touch.
struct Clearance {
  Vec4 from{};
  double until = -std::numeric_limits<double>::infinity();  // m
  // Whether a ball at (x, y, z) of radius w cannot touch yet; the margin is above all rounding, so
  // that no contact depends on when the clearance was measured. Never with a position that is not a
  // number: that is reported elsewhere.
  bool holds(const Vec4& ball, double path) const {
    constexpr double margin = 1 + 1e-9;
    const double dx = ball.x - from.x, dy = ball.y - from.y, dz = ball.z - from.z;
    const double left = until - path - margin * ball.w;
    return left > 0 && dx * dx + dy * dy + dz * dz < left * left;
  }
};

// A piece near a surface. Of own particles only.
struct Approach {
  std::int32_t piece;
  std::int32_t surface;
  Vec3 shift;                  // m, added to the piece's centre (periodic sides)
  std::vector<int> triangles;  // candidates, ascending
  int law;
  struct Patch {
    // Number within its surface; the history refers to the name of the surface and this number.
    int patch;
    bool touching;
    Vec4 xi{};
    double turn = 0;            // rad
    double size = 0, ring = 0;  // as in History
    Vec4 roll{};                // m
    // As computed in the last sub-step; radius 0: not yet.
    double overlap = 0, radius = 0;  // m
    double spread = 0;               // m^2
    Vec3 N = Vec3::Zero();           // the overlap grows along it
    Vec3 point = Vec3::Zero();       // m, beside the piece (not shifted)
  };
  std::vector<Patch> patches;  // those in contact, ascending
  NearFeatures near;           // of a piece with several corners
  Clearance clear;             // of a ball
};

// Input of the search for pairs and approaches.
struct Scene {
  const State& state;
  const Shapes& shapes;
  const Grid& grid;
  const LawTable& laws;
  const Pieces& pieces;
  double skin;    // m
  bool accounts;  // whether contacts compute what they dissipate
};

// `history` sorted; entries take theirs from it.
void find_pairs(const Scene& scene, const std::vector<History>& history, PairList& pairs,
                StoneList& stones);
void find_approaches(const Scene& scene, const std::vector<Surface*>& surfaces,
                     const std::vector<int>& names, const std::vector<History>& history,
                     std::vector<Approach>& approaches);

// Key of a patch of a surface in a History; `name` is the number of the surface's name. Negative,
// unlike keys of pieces; falls as name or patch rise.
inline std::int64_t patch_key(int name, int patch) {
  return -1 - ((static_cast<std::int64_t>(name) << 32) | patch);
}
std::vector<History> collect_history(const State& state, const Pieces& pieces,
                                     const PairList& pairs, const StoneList& stones,
                                     const std::vector<Approach>& approaches,
                                     const std::vector<int>& names);

}  // namespace trackbed::dem
