// One pair of pieces by itself: the rare work, which features it may need and what it feels with
// overlapping cores. The work of every sub-step is in stone_blocks.hpp.
#pragma once

#include <vector>

#include "features.hpp"
#include "pairs.hpp"
#include "separation.hpp"

namespace trackbed::dem {

// Both pieces placed, relative to the centre of the first one's particle.
struct PlacedPair {
  Placed i, j;
  double reach;  // m, sum of the radii
};

// With the corners that they show.
class PairSight : public PlacedPair {
 public:
  PairSight(const Scene& scene, const StoneList& list, std::int32_t piece, std::uint32_t entry);
  PairSight(const PairSight&) = delete;  // what it shows would be the other's
  PairSight& operator=(const PairSight&) = delete;

 private:
  std::vector<Vec4> corners_;  // of i, then of j
};

// Numbers of kept features: corners of i, of j, edges.
struct FeatureCounts {
  std::uint32_t of_i = 0, of_j = 0, edges = 0;
  std::size_t count() const { return static_cast<std::size_t>(of_i) + of_j + edges; }
};

// Appends the features that are nearer than `within` m now, of those that reach no deeper than
// `depth` m behind the foremost corner along the normal, from i to j. Order: corners of i, of j,
// edges, each ascending, all triangles of one corner after each other.
FeatureCounts find_features(const PlacedPair& sight, const Vec3& normal, double depth,
                            double within, std::vector<FeatureWord>& words);

// What is felt of cores that overlap, from their widest slab (`separating_axis`).
Wrench deep_wrench(const PlacedPair& sight, const Slab& widest);

}  // namespace trackbed::dem
