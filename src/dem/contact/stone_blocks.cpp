// Assignment of pairs to lanes of blocks, and the features of eight pairs at once
// (stone_blocks.hpp).
#include "dem/contact/stone_blocks.hpp"

#include <algorithm>
#include <cstddef>

#include "dem/lanes/rows.hpp"
#include "dem/shape/feature_kernels.hpp"
#include "dem/state/rotation.hpp"

namespace trackbed::dem {

namespace {

constexpr double none = -1;  // m, reach of a lane that is not used

// Numbers of features are rounded up to these, so that pairs with many features can share blocks.
std::uint16_t rounded_up(std::size_t count) {
  if (count > 12) count = (count + 3) / 4 * 4;
  if (count > 4) count = (count + 1) / 2 * 2;
  return static_cast<std::uint16_t>(count);
}

void set(LaneBits& bits, std::size_t lane, bool value) {
  const auto bit = static_cast<LaneBits>(1u << lane);
  bits = static_cast<LaneBits>(value ? bits | bit : bits & ~bit);
}

// The features of the pair in lane k; first: numbers of the first corners of i and j.
void set_features(std::span<BlockFeature> to, const Block& block, std::size_t k,
                  const PairFeatures& features, const std::array<std::uint32_t, 2>& first) {
  const std::size_t corners = features.of_i + features.of_j;
  const std::size_t edges = features.words.size() - corners;
  const auto fill = [&](BlockFeature& f, const FeatureWord& word,
                        const std::array<std::size_t, 4>& side) {
    for (std::size_t c = 0; c < 4; ++c) f.corner[c][k] = first[side[c]] + word[c];
  };
  for (std::size_t z = 0; z < block.corners; ++z) {
    BlockFeature& f = to[z];
    const bool of_j = z >= features.of_i, absent = z >= corners;
    set(f.of_j, k, of_j), set(f.absent, k, absent), set(f.continues, k, false);
    if (absent) continue;
    const FeatureWord* word = &features.words[z];
    fill(f, *word,
         of_j ? std::array<std::size_t, 4>{1, 0, 0, 0} : std::array<std::size_t, 4>{0, 1, 1, 1});
    set(f.continues, k, z > 0 && z != features.of_i && (*word)[0] == word[-1][0]);
  }
  for (std::size_t z = 0; z < block.edges; ++z) {
    BlockFeature& f = to[block.corners + z];
    set(f.absent, k, z >= edges);
    if (z < edges) fill(f, features.words[corners + z], {0, 0, 1, 1});
  }
}

}  // namespace

void WrenchLanes::set(std::size_t lane, const Wrench& w) {
  const auto put = [lane](Lanes3& to, const Vec3& v) {
    to.x[lane] = v.x(), to.y[lane] = v.y(), to.z[lane] = v.z();
  };
  M[lane] = w.M, closest[lane] = w.closest, spread[lane] = w.spread;
  put(N, w.N), put(T, w.T), put(x, w.x);
}

Wrench WrenchLanes::at(std::size_t lane) const {
  const auto get = [lane](const Lanes3& v) { return Vec3(v.x[lane], v.y[lane], v.z[lane]); };
  Wrench w;
  w.M = M[lane], w.closest = closest[lane], w.spread = spread[lane];
  w.N = get(N), w.T = get(T), w.x = get(x);
  return w;
}

void StoneBlocks::reset(std::size_t entries) {
  blocks_.clear(), features_.clear(), free_.clear(), changes_.clear();
  slots_.assign(entries, nowhere);
}

std::uint32_t StoneBlocks::free_slot(const Class& wanted) {
  std::vector<std::uint32_t>& free = free_[wanted];
  if (free.empty()) {
    const auto first = static_cast<std::uint32_t>(blocks_.size() * lanes);
    for (std::uint32_t k = lanes; k-- > 0;) free.push_back(first + k);
    Block& block = blocks_.emplace_back();
    block.reach = all(none), block.half = block.radius = block.rolling_radius = all(0);
    // Results of unused lanes are never read, but slow to compute if they are not a number.
    block.root_mass = all(1), block.inverse_moment_i = block.inverse_moment_j = all(0);
    block.features = static_cast<std::uint32_t>(features_.size());
    block.corners = wanted.corners, block.edges = wanted.edges, block.law = wanted.law;
    features_.resize(features_.size() + wanted.corners + wanted.edges);
    for (std::size_t k = block.features; k < features_.size(); ++k) features_[k].absent = 0xff;
  }
  const std::uint32_t slot = free.back();
  free.pop_back();
  return slot;
}

void StoneBlocks::set_radii(const Scene& scene, Block& block, std::size_t lane) {
  const auto i = static_cast<std::size_t>(block.piece_i[lane]);
  const auto j = static_cast<std::size_t>(block.piece_j[lane]);
  const double ri = scene.pieces.rounding[i], rj = scene.pieces.rounding[j];
  block.reach[lane] = ri + rj, block.half[lane] = 0.5 * (ri - rj);
  block.radius[lane] = ri * rj / (ri + rj);
  const double bi = scene.pieces.x[i].w, bj = scene.pieces.x[j].w;
  block.rolling_radius[lane] = bi * bj / (bi + bj);
}

void StoneBlocks::resize(const Scene& scene) {
  for (Block& block : blocks_)
    for (std::size_t k = 0; k < lanes; ++k)
      if (block.used >> k & 1) set_radii(scene, block, k);
}

void StoneBlocks::insert(const Scene& scene, const StoneList& list, std::int32_t piece,
                         std::uint32_t entry, const PairFeatures& features) {
  const Entry& other = list.entries[entry];
  const std::size_t corners = features.of_i + features.of_j;
  const std::size_t edges = features.words.size() - corners;
  const std::uint32_t slot = free_slot({other.law, rounded_up(corners), rounded_up(edges)});
  const std::size_t k = slot % lanes;
  Block& block = blocks_[slot / lanes];
  slots_[entry] = slot, changes_.push_back(entry);
  const auto body = [&](std::int32_t p) {
    return static_cast<std::uint32_t>(scene.pieces.body[static_cast<std::size_t>(p)]);
  };
  block.i[k] = body(piece), block.j[k] = body(other.piece), block.entry[k] = entry;
  block.piece_i[k] = piece, block.piece_j[k] = other.piece, block.shift[k] = other.shift;
  set(block.used, k, true), set(block.touching, k, other.touching != 0);
  set(block.watched, k, false), set(block.deep, k, false), set(block.fresh, k, false);
  set_radii(scene, block, k);
  const auto first = [&](std::int32_t p) {
    return scene.shapes.first_corner(scene.pieces.core[static_cast<std::size_t>(p)]);
  };
  set_features(std::span(features_).subspan(block.features), block, k, features,
               {first(piece), first(other.piece)});
  const Vec4 &xi = list.xi[entry], &turn = list.turn[entry];
  const Vec4 roll = list.roll.empty() ? Vec4{} : list.roll[entry];
  block.root_mass[k] = xi.w;
  block.inverse_moment_i[k] = largest_inverse_moment(scene.state, block.i[k]);
  block.inverse_moment_j[k] = largest_inverse_moment(scene.state, block.j[k]);
  block.xi.x[k] = xi.x, block.xi.y[k] = xi.y, block.xi.z[k] = xi.z;
  block.turn[k] = turn.x, block.size[k] = turn.y, block.ring[k] = turn.z;
  block.roll.x[k] = roll.x, block.roll.y[k] = roll.y, block.roll.z[k] = roll.z;
}

void StoneBlocks::store(const Block& block, std::size_t k, StoneList& list) {
  const std::uint32_t e = block.entry[k];
  list.xi[e] = {block.xi.x[k], block.xi.y[k], block.xi.z[k], block.root_mass[k]};
  list.turn[e] = {block.turn[k], block.size[k], block.ring[k], 0};
  if (!list.roll.empty()) list.roll[e] = {block.roll.x[k], block.roll.y[k], block.roll.z[k], 0};
}

void StoneBlocks::store(StoneList& list) const {
  for (const Block& block : blocks_)
    for (std::size_t k = 0; k < lanes; ++k)
      if (block.used >> k & 1) store(block, k, list);
}

void StoneBlocks::remove(std::uint32_t entry, StoneList& list) {
  const std::uint32_t slot = slots_[entry];
  const std::size_t k = slot % lanes;
  Block& block = blocks_[slot / lanes];
  store(block, k, list);
  free_[{block.law, block.corners, block.edges}].push_back(slot);
  block.reach[k] = none;
  for (LaneBits* bits : {&block.used, &block.touching, &block.watched, &block.deep})
    set(*bits, k, false);
  slots_[entry] = nowhere, changes_.push_back(entry);
}

namespace {

// Sums of the smooth maximum of eight pairs.
struct Sums {
  Lanes power = all(0), weight = all(0), square = all(0), closest = all(1e300);
  Lanes3 normal{all(0), all(0), all(0)}, moment = normal, point = normal;

  // Only of lanes in the mask.
  [[gnu::always_inline]] void add(const FeatureGroup& g) {
    power = power + g.power, weight = weight + g.weight, square = square + g.square;
    normal = normal + g.normal, moment = moment + g.moment, point = point + g.point;
    closest = smaller(g.d, closest);
  }
};

// Lanes that are not chosen add nothing.
[[gnu::always_inline]] inline void keep(Mask chosen, FeatureGroup& g) {
  const Lanes zero = all(0);
  const Lanes3 zeros{zero, zero, zero};
  g.power = select(chosen, g.power, zero), g.weight = select(chosen, g.weight, zero);
  g.square = select(chosen, g.square, zero), g.d = select(chosen, g.d, all(1e300));
  g.normal = select(chosen, g.normal, zeros), g.moment = select(chosen, g.moment, zeros);
  g.point = select(chosen, g.point, zeros);
}

[[gnu::always_inline]] inline void choose(Mask first, const FeatureGroup& a, FeatureGroup& b) {
  b.power = select(first, a.power, b.power), b.weight = select(first, a.weight, b.weight);
  b.square = select(first, a.square, b.square), b.d = select(first, a.d, b.d);
  b.normal = select(first, a.normal, b.normal), b.moment = select(first, a.moment, b.moment);
  b.point = select(first, a.point, b.point);
}

// x^(1/6): the cube root of the square root, by Halley's iteration from an estimate that divides
// the exponent by three; accurate to 1e-15.
[[gnu::always_inline]] inline Lanes sixth_root(Lanes x) {
  using Bits [[gnu::vector_size(64)]] = std::uint64_t;
  const Lanes r = root(x);
  Lanes y = (Lanes)(((Bits)r >> 32) * 0x55555555ull + 0x2a9f7893782da1ceull);  // reinterpreted
  for (int k = 0; k < 3; ++k) {
    const Lanes y3 = y * y * y;
    y = y * (y3 + 2 * r) / (2 * y3 + r);
  }
  return y;
}

// As `Overlaps::result`.
[[gnu::always_inline]] inline WrenchLanes result(const Sums& s, const Lanes3& d) {
  const Mask some = s.power > all(1e-300);
  const Lanes zero = all(0);
  const Lanes3 zeros{zero, zero, zero};
  const Lanes power = select(some, s.power, all(1)), M = sixth_root(power);
  const Lanes factor = M / power, over_weight = all(1) / select(some, s.weight, all(1));
  const Lanes3 x = over_weight * s.point;
  const Lanes spread = larger(s.square * over_weight - dot(x, x), zero);
  return {select(some, M, zero),
          s.closest,
          select(some, spread, zero),
          select(some, factor * s.normal, zeros),
          select(some, factor * s.moment, zeros),
          select(some, x, zeros),
          d};
}

// Columns of scale times rotation.
struct TurnLanes {
  Lanes3 x, y, z;

  TurnLanes() = default;
  [[gnu::always_inline]] TurnLanes(const std::vector<Vec4>& turns, const LaneNumbers& bodies) {
    const auto column = [&](std::size_t c) {
      return rows(turns.data() + c, [&](std::size_t k) { return 3 * std::size_t{bodies[k]}; });
    };
    x = column(0).xyz(), y = column(1).xyz(), z = column(2).xyz();
  }
  [[gnu::always_inline]] Lanes3 operator()(const Lanes3& o) const {
    return o.x * x + o.y * y + o.z * z;
  }
  // The first in lanes of the mask, the second in others.
  [[gnu::always_inline]] static TurnLanes either(Mask mask, const TurnLanes& a,
                                                 const TurnLanes& b) {
    TurnLanes t;
    t.x = select(mask, a.x, b.x), t.y = select(mask, a.y, b.y), t.z = select(mask, a.z, b.z);
    return t;
  }
};

// Computes the points of the features of a block. The corners of all shapes together are few and in
// the nearest cache: rotating them again for each feature takes less time than reading rotated
// ones.
struct BlockPoints {
  const Vec4* corners;
  Lanes3 d;  // m, of j from i
  TurnLanes turn_i, turn_j;

  [[gnu::always_inline]] Lanes3 at(const TurnLanes& turn, const LaneNumbers& numbers) const {
    return turn(rows(corners, [&](std::size_t k) { return numbers[k]; }).xyz());
  }
  [[gnu::always_inline]] void corner(const BlockFeature& f, FeatureGroup& g) const {
    const Mask of_j = mask_of(f.of_j);
    const Lanes3 zeros{all(0), all(0), all(0)};
    const Lanes3 own = select(of_j, d, zeros), other = select(of_j, zeros, d);
    g.side = select(of_j, all(-1), all(1));
    g.p[0] = at(TurnLanes::either(of_j, turn_j, turn_i), f.corner[0]) + own;
    const TurnLanes turn = TurnLanes::either(of_j, turn_i, turn_j);
    for (std::size_t c = 1; c < 4; ++c) g.p[c] = at(turn, f.corner[c]) + other;
  }
  [[gnu::always_inline]] void edges(const BlockFeature& f, FeatureGroup& g) const {
    g.p[0] = at(turn_i, f.corner[0]), g.p[1] = at(turn_i, f.corner[1]);
    g.p[2] = at(turn_j, f.corner[2]) + d, g.p[3] = at(turn_j, f.corner[3]) + d;
  }
};

// The distance of a corner to the other core is the least to its triangles, which follow each
// other; of equal ones the first.
[[gnu::always_inline]] inline void add_corners(const BlockPoints& points,
                                               std::span<const BlockFeature> features,
                                               FeatureGroup& g, Sums& sums) {
  FeatureGroup best;
  for (std::size_t z = 0; z < features.size(); ++z) {
    const BlockFeature& f = features[z];
    points.corner(f, g);
    corner_and_triangle(g);
    if (f.absent) keep(~mask_of(f.absent), g);
    if (z > 0) {
      if (f.continues) {
        const Mask continues = mask_of(f.continues);
        FeatureGroup before = best;
        keep(~continues, before);
        sums.add(before);
        choose(continues & ~(g.d < best.d), best, g);
      } else {
        sums.add(best);
      }
    }
    best = g;
  }
  if (!features.empty()) sums.add(best);
}

}  // namespace

// Blocks of one class are in an arbitrary order of their features.
void StoneBlocks::prefetch(std::size_t n) const {
  if (n >= blocks_.size()) return;
  const auto lines = [](const void* from, std::size_t bytes) {
    constexpr std::size_t line = 64;
    for (std::size_t k = 0; k < bytes; k += line)
      __builtin_prefetch(static_cast<const std::byte*>(from) + k);
  };
  const Block& block = blocks_[n];
  lines(&block, offsetof(Block, roll));
  if (n > 0) {
    const Block& sooner = blocks_[n - 1];  // whose numbers are loaded by now
    const std::size_t count = std::size_t{sooner.corners} + sooner.edges;
    lines(features_.data() + sooner.features, count * sizeof(BlockFeature));
  }
}

WrenchLanes StoneBlocks::wrenches(const Block& block, const Scene& scene,
                                  const StoneList& list) const {
  const Vec4* x = scene.state.x.data();
  const Lanes3 xi = rows(x, [&](std::size_t k) { return block.i[k]; }).xyz();
  const Lanes3 xj = rows(x, [&](std::size_t k) { return block.j[k]; }).xyz();
  const Lanes3 h = rows(list.shifts.data(), [&](std::size_t k) { return block.shift[k]; }).xyz();
  const std::vector<Vec4>& turns = scene.pieces.turns;
  const BlockPoints points{
      scene.shapes.corners().data(), xj - xi + h, {turns, block.i}, {turns, block.j}};
  FeatureGroup g;
  g.reach = block.reach, g.half = block.half;
  Sums sums;
  const std::span<const BlockFeature> features(features_);
  add_corners(points, features.subspan(block.features, block.corners), g, sums);
  for (const BlockFeature& f : features.subspan(block.features + block.corners, block.edges)) {
    points.edges(f, g);
    edge_and_edge(g);
    if (f.absent) keep(~mask_of(f.absent), g);
    sums.add(g);
  }
  return result(sums, points.d);
}

std::size_t StoneBlocks::memory() const {
  std::size_t bytes = blocks_.capacity() * sizeof(Block) +
                      features_.capacity() * sizeof(BlockFeature) +
                      (slots_.capacity() + changes_.capacity()) * sizeof(slots_[0]);
  for (const auto& [key, free] : free_) bytes += free.capacity() * sizeof(free[0]);
  return bytes;
}

}  // namespace trackbed::dem
