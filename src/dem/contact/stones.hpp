// Pairs in which a piece has more than one corner.
//
// The main task is to skip unnecessary work. Each pair keeps the features that may come within
// contact before its two bodies have moved by a margin (`Reach::until` counts the length of their
// paths); usually a handful. Once the paths have used it up, the relative pose of the two bodies
// gives the remaining margin, because stones mostly move together or oscillate; features are
// searched again when nothing remains, from the widest empty slab between the cores: only corners,
// edges and triangles that reach into it may touch. New neighbour lists change none of this: a pair
// is identified by its ids. The choice of kept features does not affect results: a feature out of
// reach adds nothing, and those within reach are summed in the order of their numbers.
//
// A pair that may touch has a lane of a block (stone_blocks.hpp), in which each sub-step computes
// its wrench; a pair that is too far apart has none until its paths have closed the gap.
//
// Cost: one comparison for each two particles with listed pairs; per kept feature about 150 flops
// in a lane, per pair in a block 350. A search for features costs many times that and is rare in a
// bed at rest. Distances are always up to date; only the choice of features is kept. Margins are
// lengths of paths and not times, so a stone that is shaken and then rests is checked only as often
// as it has moved.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "dem/contact/stone_blocks.hpp"
#include "dem/contact/stone_law.hpp"
#include "dem/contact/stone_pair.hpp"
#include "dem/search/pairs.hpp"
#include "dem/shape/features.hpp"

namespace trackbed::dem {

// A pair that overlaps.
struct Overlap {
  std::uint32_t entry;
  std::int32_t piece;  // i
  Wrench wrench;
};

// Belongs to one list and one layout of pieces; entries and `reaches_` have the same numbers.
class StoneContacts {
 public:
  // To be called after the list and the pieces have been rebuilt. Pairs that are still listed keep
  // their features as long as their poses allow.
  void reset(const Scene& scene, const StoneList& list);
  // Adds forces and torques of all pairs that overlap to the particles, in the order of the list;
  // advances their history by dt. Pairs that do not overlap lose it. Returns the largest overlap
  // over the smaller radius.
  double compute_forces(const Scene& scene, double dt, StoneList& list, State& state);
  // Writes histories to the list, where they are read; between calls of `compute_forces` they are
  // in blocks.
  void store(StoneList& list) const { blocks_.store(list); }
  // The pairs that overlapped in the last `compute_forces`, in the order of the list; the pieces as
  // then.
  std::vector<Overlap> overlaps(const Scene& scene, const StoneList& list) const;
  // Pairs found with overlapping cores up to now, counted in each sub-step; of own first particles.
  std::int64_t deep() const { return deep_; }
  std::size_t features(std::uint32_t entry) const { return reaches_[entry].features.count(); }
  std::size_t memory() const;

 private:
  // Data kept for a pair.
  struct Reach {
    std::uint32_t begin = 0;  // in words_
    FeatureCounts features;
    bool watch = false;          // cores so close that overlap is checked in each sub-step
    double until = -1;           // m, sum of both paths up to which this is certainly valid
    double no_contact = -1;      // m, the same up to which contact is impossible
    double slack = 0;            // m, possible approach, in truth, while this is valid
    double gap = 0;              // m, the same while contact is impossible; 0: not known
    Vec3 normal = Vec3::Zero();  // of the last slab
  };
  // Pose of j relative to i. In single precision: an allowance covers its error (`closed`).
  struct Pose {
    std::array<float, 3> x;  // m, centre
    std::array<float, 4> q;  // attitude
    float size;              // m, sum of the radii around both
  };
  struct Key {
    std::int64_t i, j;  // `piece_key` of both
    auto operator<=>(const Key&) const = default;
  };
  // When an entry must be checked.
  struct Check {
    double next;           // m, sum of both paths
    std::uint32_t i, j;    // particles
    std::uint32_t couple;  // number of their couple
  };
  // Two particles with entries: when the first of these must be checked.
  struct Couple {
    double next;
    std::uint32_t i, j;
    std::uint32_t begin;  // in entries_of_couples_; they end where the next begin
  };

  static Pose pose(const Scene& scene, const StoneList& list, const Check& pair,
                   std::uint32_t entry);
  static double closed(const Pose& a, const Pose& b, double r);
  bool still_valid(const Scene& scene, const StoneList& list, std::uint32_t e, double path);
  void update_features(const Scene& scene, const StoneList& list, std::uint32_t e, double path);
  void check_entry(const Scene& scene, StoneList& list, std::uint32_t e);
  void check_all(const Scene& scene, StoneList& list);
  void check_couple(const Scene& scene, StoneList& list, std::size_t couple, double path);
  void find_couples(const StoneList& list);
  void release_lane(StoneList& list, std::uint32_t e);
  void handle_gap(const Scene& scene, StoneList& list, Block& block, std::size_t lane,
                  double closest);
  void update_block(const Scene& scene, StoneList& list, Block& block, WrenchLanes& w);
  void check_core_overlap(const Scene& scene, const StoneList& list, Block& block, std::size_t lane,
                          WrenchLanes& w);
  void put_in_order();
  void compact();

  std::vector<Reach> reaches_;
  std::vector<Pose> poses_;  // when the features of each entry were found
  std::vector<Check> checks_;
  std::vector<Couple> couples_;  // one more at the end
  std::vector<std::uint32_t> entries_of_couples_;
  std::vector<std::int32_t> pieces_;  // i of each entry
  std::vector<Key> keys_;             // of the entries: identity independent of their numbers
  std::vector<FeatureWord> words_;
  std::size_t live_ = 0;  // words in use; the others were replaced by new ones
  StoneBlocks blocks_;
  double grown_ = 1;  // size fraction of growing particles in the blocks
  PairForces forces_;
  std::vector<PlaceOfPair> order_;  // of pairs that have been in blocks, as in the list
  std::int64_t deep_ = 0;
};

}  // namespace trackbed::dem
