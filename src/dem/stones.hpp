// Pairs in which a piece has more than one corner.
//
// Most of the work is in knowing what to leave out. Each pair keeps the features that may come
// within contact before its two bodies have moved by a margin (`Reach::until` counts the length of
// their paths); usually a handful. Once the paths have used it up, the pose of one body seen from
// the other tells how much is left, for stones mostly move with each other or to and fro; features
// are found anew when there is nothing left, from the widest empty slab between the cores: only
// corners, edges and triangles that reach into it may touch. New neighbour lists change none of
// this: a pair is known by its ids. Which features a pair keeps changes no bit: one out of reach
// adds nothing, and those within reach are summed in the order of their numbers.
//
// A pair that may touch has a lane of a block (stone_blocks.hpp), in which each sub-step computes
// what it feels; one that is too far apart has none and waits until its paths have closed the gap.
//
// Cost: one comparison for each two particles with listed pairs; per kept feature about 150 flops
// in a lane, per pair in a block 350. Finding features anew costs many times that and is rare in a
// bed at rest. Distances are always fresh; only the choice is kept. Margins are lengths of paths
// and not times, so a stone that is shaken and comes to rest is looked at as often as it has moved,
// no more.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "features.hpp"
#include "pairs.hpp"
#include "stone_blocks.hpp"
#include "stone_law.hpp"
#include "stone_pair.hpp"

namespace trackbed::dem {

// A pair that overlaps.
struct Overlap {
  std::uint32_t entry;
  std::int32_t piece;  // i
  Wrench wrench;
};

// Belongs to one list and one lay-out of pieces; entries and `reaches_` have the same numbers.
class StoneContacts {
 public:
  // To be called when the list and the pieces have been made anew. Pairs that are still listed
  // keep their features for as long as their poses say.
  void reset(const Scene& scene, const StoneList& list);
  // Adds forces and torques of all pairs that overlap to the particles, in the order of the list;
  // moves their history by dt. Those that do not overlap lose it. Returns the largest overlap over
  // the smaller radius.
  double feel(const Scene& scene, double dt, StoneList& list, State& state);
  // Histories to the list, where they are read; `feel` keeps them elsewhere meanwhile.
  void store(StoneList& list) const { blocks_.store(list); }
  // The pairs that overlapped in the last `feel`, in the order of the list; the pieces as then.
  std::vector<Overlap> overlaps(const Scene& scene, const StoneList& list) const;
  // So far: pairs found with one core in another, in each sub-step anew; of own first particles.
  std::int64_t deep() const { return deep_; }
  std::size_t features(std::uint32_t entry) const { return reaches_[entry].features.count(); }
  std::size_t memory() const;

 private:
  // What is kept of a pair.
  struct Reach {
    std::uint32_t begin = 0;  // in words_
    FeatureCounts features;
    bool watch = false;          // cores so close that each sub-step looks whether they overlap
    double until = -1;           // m, sum of both paths up to which this holds for certain
    double quiet = -1;           // m, and up to which nothing can touch
    double slack = 0;            // m, that they may come closer, in truth, while this holds
    double gap = 0;              // m, the same while nothing can touch; 0: not known
    Vec3 normal = Vec3::Zero();  // of the last slab
  };
  // How j lies seen from i. In single precision: an allowance covers it (`closed`).
  struct Pose {
    std::array<float, 3> x;  // m, centre
    std::array<float, 4> q;  // attitude
    float size;              // m, sum of the radii around both
  };
  struct Key {
    std::int64_t i, j;  // `piece_key` of both
    auto operator<=>(const Key&) const = default;
  };
  // When an entry must be looked at.
  struct Look {
    double next;           // m, sum of both paths
    std::uint32_t i, j;    // particles
    std::uint32_t couple;  // theirs
  };
  // Two particles with entries: when the first of these must be looked at.
  struct Couple {
    double next;
    std::uint32_t i, j;
    std::uint32_t begin;  // in entries_of_couples_; they end where the next begin
  };

  static Pose pose(const Scene& scene, const StoneList& list, const Look& pair,
                   std::uint32_t entry);
  static double closed(const Pose& a, const Pose& b, double r);
  bool still_good(const Scene& scene, const StoneList& list, std::uint32_t e, double path);
  void find_features_anew(const Scene& scene, const StoneList& list, std::uint32_t e, double path);
  void look(const Scene& scene, StoneList& list, std::uint32_t e);
  void look_at_all(const Scene& scene, StoneList& list);
  void look_at(const Scene& scene, StoneList& list, std::size_t couple, double path);
  void find_couples(const StoneList& list);
  void rest(StoneList& list, std::uint32_t e);
  void part(const Scene& scene, StoneList& list, Block& block, std::size_t lane, double closest);
  void follow(const Scene& scene, StoneList& list, Block& block, WrenchLanes& w);
  void watch(const Scene& scene, const StoneList& list, Block& block, std::size_t lane,
             WrenchLanes& w);
  void put_in_order();
  void compact();

  std::vector<Reach> reaches_;
  std::vector<Pose> poses_;  // when the features of each entry were found
  std::vector<Look> looks_;
  std::vector<Couple> couples_;  // one more at the end
  std::vector<std::uint32_t> entries_of_couples_;
  std::vector<std::int32_t> pieces_;  // i of each entry
  std::vector<Key> keys_;             // of the entries: who they are whatever their numbers
  std::vector<FeatureWord> words_;
  std::size_t live_ = 0;  // words in use; the others are of pairs that found new ones
  StoneBlocks blocks_;
  double grown_ = 1;  // share of the size of growing particles that the blocks know
  PairForces forces_;
  std::vector<PlaceOfPair> order_;  // of pairs that have been in blocks, as in the list
  std::int64_t deep_ = 0;
};

}  // namespace trackbed::dem
