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
// Cost per kept feature: about 100 flops of 8 lanes and 12 scalar loads; per touching pair 300
// flops. Finding features anew costs many times that and is rare in a bed at rest.
// Distances are always fresh; only the choice is kept. Margins are lengths of paths and not times,
// so a stone that is shaken and comes to rest is looked at as often as it has moved, no more.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "features.hpp"
#include "pairs.hpp"
#include "separation.hpp"

namespace trackbed::dem {

// Pairs that overlap, in the order of the list, on their way to the law.
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
  // All pairs that overlap now. Those that do not lose their history.
  const std::vector<Overlap>& find(const Scene& scene, StoneList& list);
  const std::vector<Overlap>& found() const { return found_; }  // by the last `find`
  // So far: pairs found with one core in another, in each sub-step anew; of own first particles.
  std::int64_t deep() const { return deep_; }
  std::size_t features(std::uint32_t entry) const { return reaches_[entry].count(); }  // kept
  std::size_t memory() const;

 private:
  // What is kept of a pair.
  struct Reach {
    std::uint32_t begin = 0;                      // in words_
    std::uint32_t of_i = 0, of_j = 0, edges = 0;  // features: corners of i, corners of j, edges
    bool watch = false;          // cores so close that each sub-step looks whether they overlap
    double until = -1;           // m, sum of both paths up to which this holds for certain
    double quiet = -1;           // m, and up to which nothing can touch
    double slack = 0;            // m, that they may come closer, in truth, while this holds
    double gap = 0;              // m, the same while nothing can touch; 0: not known
    Vec3 normal = Vec3::Zero();  // of the last slab
    std::size_t count() const { return static_cast<std::size_t>(of_i) + of_j + edges; }
  };
  // A pair whose features wait in the rows until these are full.
  struct Pending {
    std::uint32_t entry;
    std::int32_t piece;
    FeatureSet set;
    double reach, path;  // m, sums of the radii and of the bodies' paths
    bool fresh;          // features found in this sub-step
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
  struct Sight;

  static Pose pose(const Scene& scene, const StoneList& list, std::int32_t p, const Entry& other);
  static double closed(const Pose& a, const Pose& b, double r);
  bool still_good(const Scene& scene, const StoneList& list, std::int32_t p, std::uint32_t e,
                  double path);
  void refresh(const Sight& sight, Reach& reach, double path, double pace);
  void keep_features(const Sight& sight, Reach& reach, double depth, double within);
  FeatureSet gather(const Sight& sight, const Reach& reach, FeatureRow& corners,
                    FeatureRow& edges) const;
  void flush(const Scene& scene, StoneList& list);
  Wrench wrench(const Scene& scene, const StoneList& list, const Pending& p);
  Wrench moved_wrench(const Sight& sight, const Vec3& n, double length);
  Wrench deep_wrench(const Sight& sight, const Slab& widest);
  void compact();

  std::vector<Reach> reaches_;
  std::vector<Pose> poses_;  // when the features of each entry were found
  std::vector<Key> keys_;    // of the entries: who they are whatever their numbers
  std::vector<FeatureWord> words_;
  std::size_t live_ = 0;  // words in use; the others are of pairs that found new ones
  FeatureRow corners_, edges_;
  std::vector<Pending> pending_;
  std::vector<Overlap> found_;
  std::int64_t deep_ = 0;
};

// Adds forces and torques of the overlapping pairs to the particles, in their order; moves their
// history by dt. Returns the largest overlap over the smaller radius.
double feel_stones(const std::vector<Overlap>& overlaps, const Scene& scene, double dt,
                   StoneList& list, State& state);

}  // namespace trackbed::dem
