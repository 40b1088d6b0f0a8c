// Pairs of stones eight at a time: a lane is a pair. A block holds eight pairs with about the same
// number of kept features; feature z of all eight is computed together, the sums of their smooth
// maxima stay in registers, and the law follows in the same lanes (stone_law.cpp).
//
// A pair stays in its lane until its features change or it is out of reach: then the lane is empty
// until another pair with as many features takes it. The result of a lane depends on its pair only,
// and forces are added in the order of the list afterwards, so neither the block nor the lane of a
// pair affects results. Its history is in the lane as well.
//
// Rejected: rows of features of one kind, gathered for each pair and summed for each pair. The
// short loops over a pair's features have varying lengths, which processors cannot predict, and
// took longer than the arithmetic.
#pragma once

#include <limits>
#include <map>
#include <span>
#include <vector>

#include "dem/search/pairs.hpp"
#include "dem/shape/features.hpp"

namespace trackbed::dem {

using LaneBits = std::uint8_t;  // a bit for each lane of a block
using LaneNumbers = std::array<std::uint32_t, lanes>;

[[gnu::always_inline]] inline Mask mask_of(LaneBits bits) {
  constexpr Mask each = {1, 2, 4, 8, 16, 32, 64, 128};
  return ((Mask{} + bits) & each) != Mask{};
}

// Wrenches of pairs, one per lane: `Wrench`, and the centre of j relative to that of i.
struct WrenchLanes {
  Lanes M, closest, spread;
  Lanes3 N, T, x, d;
  void set(std::size_t lane, const Wrench& w);
  Wrench at(std::size_t lane) const;
};

// Feature z of eight pairs: numbers of four corners in `Shapes::corners`, first the corner, then
// the triangle, or the edge of i, then that of j.
struct BlockFeature {
  std::array<LaneNumbers, 4> corner;
  LaneBits of_j;       // the corner is one of j
  LaneBits continues;  // same corner as the feature before: the nearer one counts
  LaneBits absent;     // the pair has fewer features
};

struct alignas(64) Block {
  Lanes reach, half;        // m, as FeatureGroup
  Lanes radius;             // m, of the curvatures of both roundings together
  Lanes rolling_radius;     // m, of the balls around both pieces
  LaneNumbers i, j, entry;  // particles; number in the list
  std::array<std::int32_t, lanes> piece_i, piece_j;
  std::array<std::uint16_t, lanes> shift;
  std::uint32_t features;  // number of the first one
  // Numbers of features: two stones face to face may have more than 255 of a kind.
  std::uint16_t corners, edges;
  std::uint8_t law;
  LaneBits used, touching, watched, deep;    // deep: cores overlap
  LaneBits fresh;                            // features found in this sub-step
  Lanes root_mass;                           // kg^0.5, of the effective mass
  Lanes inverse_moment_i, inverse_moment_j;  // 1/(kg m2), over the least moments; 0: held
  // History; the list is outdated meanwhile (`store`). Zero for pairs that are not in contact.
  Lanes3 xi;               // m
  Lanes turn, size, ring;  // as in History
  Lanes3 roll;             // m; only if a law resists rolling
};

// The features of a pair: corners of i, of j, edges.
struct PairFeatures {
  std::span<const FeatureWord> words;
  std::size_t of_i, of_j;
};

class StoneBlocks {
 public:
  static constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

  // Clears all; for a list with this number of entries.
  void reset(std::size_t entries);
  void insert(const Scene& scene, const StoneList& list, std::int32_t piece, std::uint32_t entry,
              const PairFeatures& features);
  void remove(std::uint32_t entry, StoneList& list);  // its history goes to the list
  void store(StoneList& list) const;                  // all histories
  bool has(std::uint32_t entry) const { return slots_[entry] != nowhere; }
  // Block and lane, 8 block + lane; `nowhere` if it is in none.
  std::uint32_t slot(std::uint32_t entry) const { return slots_[entry]; }
  Block& block_of(std::uint32_t entry) { return blocks_[slots_[entry] / lanes]; }
  // Updates radii of pieces that have grown.
  void resize(const Scene& scene);
  // Begins to load block n and its features, if it exists.
  void prefetch(std::size_t n) const;
  // Wrenches of the pairs of a block. Those of unused lanes are zero.
  WrenchLanes wrenches(const Block& block, const Scene& scene, const StoneList& list) const;

  std::vector<Block>& blocks() { return blocks_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  // Entries that were inserted or removed, some more than once; cleared by the caller after use.
  std::vector<std::uint32_t>& changes() { return changes_; }
  std::size_t memory() const;

 private:
  struct Class {
    std::uint8_t law;
    std::uint16_t corners, edges;
    auto operator<=>(const Class&) const = default;
  };
  std::uint32_t free_slot(const Class& wanted);
  static void store(const Block& block, std::size_t lane, StoneList& list);
  void set_radii(const Scene& scene, Block& block, std::size_t lane);

  std::vector<Block> blocks_;
  std::vector<BlockFeature> features_;
  std::vector<std::uint32_t> slots_;                  // of each entry
  std::map<Class, std::vector<std::uint32_t>> free_;  // unused lanes, the last first
  std::vector<std::uint32_t> changes_;
};

}  // namespace trackbed::dem
