// One pair of pieces by itself: the infrequent work, namely the search for features and the wrench
// of overlapping cores. The work of every sub-step is in stone_blocks.hpp.
#pragma once

#include <vector>

#include "dem/search/pairs.hpp"
#include "dem/shape/features.hpp"
#include "dem/shape/separation.hpp"

namespace trackbed::dem {

// Both pieces placed, relative to the centre of the first one's particle.
struct PlacedPair {
  Placed i, j;
  double reach;  // m, sum of the radii
};

// Owns the corners that it refers to.
class PairView : public PlacedPair {
 public:
  PairView(const Scene& scene, const StoneList& list, std::int32_t piece, std::uint32_t entry);
  PairView(const PairView&) = delete;  // a copy would refer to the corners of the original
  PairView& operator=(const PairView&) = delete;

 private:
  std::vector<Vec4> corners_;  // of i, then of j
};

// Numbers of kept features: corners of i, of j, edges.
struct FeatureCounts {
  std::uint32_t of_i = 0, of_j = 0, edges = 0;
  std::size_t count() const { return static_cast<std::size_t>(of_i) + of_j + edges; }
};

// Appends the features that are now nearer than `within` m, of those that are no deeper than
// `depth` m behind the foremost corner along the normal, from i to j. Order: corners of i, of j,
// edges, each ascending, all triangles of one corner after each other.
FeatureCounts find_features(const PlacedPair& pair, const Vec3& normal, double depth, double within,
                            std::vector<FeatureWord>& words);

// The wrench of cores that overlap, from their widest slab (`separating_axis`).
Wrench deep_wrench(const PlacedPair& pair, const Slab& widest);

}  // namespace trackbed::dem
