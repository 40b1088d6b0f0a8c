// Pairs of stones eight at a time: a lane is a pair. A block holds eight pairs with about as many
// kept features; feature z of all eight is computed together, the sums of their smooth maxima stay
// in registers, and the law follows in the same lanes (stone_law.cpp).
//
// A pair stays in its lane until its features change or it is out of reach: then the lane is empty
// until another pair with as many features takes it. What a lane computes depends on its pair
// alone, and forces are added in the order of the list afterwards, so neither the block nor the
// lane of a pair changes a bit. Its history is in the lane as well.
//
// Rejected: rows of features of one kind, gathered for each pair and summed for each pair. The
// short loops over a pair's features end differently each time, which processors cannot predict,
// and took longer than the arithmetic.
#pragma once

#include <limits>
#include <map>
#include <span>
#include <vector>

#include "features.hpp"
#include "pairs.hpp"

namespace trackbed::dem {

using LaneBits = std::uint8_t;  // a bit for each lane of a block
using LaneNumbers = std::array<std::uint32_t, lanes>;

[[gnu::always_inline]] inline Mask mask_of(LaneBits bits) {
  constexpr Mask each = {1, 2, 4, 8, 16, 32, 64, 128};
  return ((Mask{} + bits) & each) != Mask{};
}

// What pairs feel, a lane each: `Wrench`, and the centre of j seen from that of i.
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
  LaneBits continues;  // same corner as the feature before: the nearer counts
  LaneBits absent;     // the pair has fewer
};

struct alignas(64) Block {
  Lanes reach, half;        // m, as FeatureGroup
  Lanes radius;             // m, of the curvatures of both roundings together
  Lanes rolling_radius;     // m, of the balls around both pieces
  LaneNumbers i, j, entry;  // particles; number in the list
  std::array<std::int32_t, lanes> piece_i, piece_j;
  std::array<std::uint16_t, lanes> shift;
  std::uint32_t features;  // number of the first one
  // Features there are: two stones that lie face on face may have more than 255 of a kind.
  std::uint16_t corners, edges;
  std::uint8_t law;
  LaneBits used, touching, watched, deep;  // deep: cores overlap
  LaneBits fresh;                          // features found in this sub-step
  Lanes root_mass;                         // kg^0.5, of the effective mass
  // History; that in the list is old meanwhile (`store`). Zero of pairs that do not touch.
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

  // Empties all; for a list of so many entries.
  void reset(std::size_t entries);
  void insert(const Scene& scene, const StoneList& list, std::int32_t piece, std::uint32_t entry,
              const PairFeatures& features);
  void remove(std::uint32_t entry, StoneList& list);  // its history goes to the list
  void store(StoneList& list) const;                  // all histories
  bool has(std::uint32_t entry) const { return slots_[entry] != nowhere; }
  // Block and lane, 8 block + lane; `nowhere` if it is in none.
  std::uint32_t slot(std::uint32_t entry) const { return slots_[entry]; }
  Block& block_of(std::uint32_t entry) { return blocks_[slots_[entry] / lanes]; }
  // Radii anew, for pieces that have grown.
  void resize(const Scene& scene);
  // Begins to load block n and its features, if there is one.
  void prefetch(std::size_t n) const;
  // What the pairs of a block feel now. Lanes that are not used feel nothing.
  WrenchLanes wrenches(const Block& block, const Scene& scene, const StoneList& list) const;

  std::vector<Block>& blocks() { return blocks_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  // Entries that came or went, some more than once; emptied by who has followed them.
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
  std::map<Class, std::vector<std::uint32_t>> free_;  // lanes to be had, the last first
  std::vector<std::uint32_t> changes_;
};

}  // namespace trackbed::dem
