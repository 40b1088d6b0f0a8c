// Distances between features of two cores, eight at a time, and the resulting wrench on a pair of
// pieces: the smooth maximum of all overlaps.
//
// Features: each corner to the closed other core (the least distance to its triangles), each edge
// to each edge (both nearly closed). Every distance has a continuous gradient, so the force is
// continuous:
//   delta_k = r_i + r_j - d_k > 0,   M = (sum delta_k^p)^(1/p),   energy U(M)
// The force on i is -U'(M) N, N = sum s_k n_k, s_k = dM/d delta_k = (delta_k / M)^(p-1), and its
// torque -U'(M) T with T = sum s_k x_k x n_k, n_k from i to j: exactly the gradient of U for any
// features. The deepest feature dominates, equal ones contribute equally. p = 6: see
// docs/decisions/stone-contact.md.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dem/lanes/lanes.hpp"
#include "dem/shape/core.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::dem {

// Four corners of two features: a corner and a triangle, or two edges.
using FeatureWord = std::array<std::uint8_t, 4>;

// Eight pairs of features. In: four points in m from a common origin near them; for corner features
// the corner, then the triangle. Out: distance, normal, point of contact, and the terms of the
// smooth maximum.
struct FeatureGroup {
  Lanes3 p[4];
  Lanes side;    // 1: the corner is one of i; -1: one of j
  Lanes reach;   // m, sum of the radii
  Lanes half;    // m, (r_i - r_j) / 2
  Lanes d;       // m
  Lanes3 n, x;   // gradient of d: normal from i to j (unit for corners); m, point of contact
  Lanes power;   // delta^6; 0 without overlap
  Lanes weight;  // delta^5, and its products with normal, moment, point and its square
  Lanes3 normal, moment, point;
  Lanes square;
};

// A row of features of one kind, filled and computed together.
// Groups are kept when the row is cleared: nothing is allocated once a row has reached its largest
// length. Spare lanes of the last group hold old numbers; they are computed and never read.
class FeatureRow {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  // Adds a pair of features of pieces with these radii; p: m.
  void add(double side, double radius_i, double radius_j, const std::array<Vec4, 4>& p) {
    const std::size_t slot = size_++, lane = slot % lanes;
    if (slot / lanes >= groups_.size()) groups_.emplace_back();
    FeatureGroup& g = groups_[slot / lanes];
    for (std::size_t k = 0; k < 4; ++k)
      g.p[k].x[lane] = p[k].x, g.p[k].y[lane] = p[k].y, g.p[k].z[lane] = p[k].z;
    g.side[lane] = side;
    g.reach[lane] = radius_i + radius_j;
    g.half[lane] = 0.5 * (radius_i - radius_j);
  }
  const FeatureGroup& group(std::size_t slot) const { return groups_[slot / lanes]; }
  double distance(std::size_t slot) const { return group(slot).d[slot % lanes]; }
  Vec3 normal(std::size_t slot) const { return at(group(slot).n, slot % lanes); }
  Vec3 contact(std::size_t slot) const { return at(group(slot).x, slot % lanes); }
  void compute_corners();
  void compute_edges();

 private:
  static Vec3 at(const Lanes3& v, std::size_t lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }
  std::vector<FeatureGroup> groups_;
  std::size_t size_ = 0;
};

// Generalised overlap and its gradient for a pair. Without overlap M = 0.
struct Wrench {
  double M = 0;            // m, smooth maximum of the overlaps
  double closest = 1e300;  // m, least distance found
  Vec3 N = Vec3::Zero();   // sum s_k n_k
  Vec3 T = Vec3::Zero();   // m, sum s_k x_k x n_k
  Vec3 x = Vec3::Zero();   // m, mean point of contact, weighted by s_k
  double spread = 0;       // m^2, weighted mean square distance of the points from it
};

// Collects the overlaps of one pair; their order affects the last bits.
class Overlaps {
 public:
  void add(double delta, const Vec3& n, const Vec3& x);  // m; n from i to j; nothing if delta <= 0
  void add(const FeatureRow& row, std::size_t slot) {
    const FeatureGroup& g = row.group(slot);
    const std::size_t k = slot % lanes;
    const auto at = [k](const Lanes3& v) { return Vec3(v.x[k], v.y[k], v.z[k]); };
    power_ += g.power[k], weight_ += g.weight[k], square_ += g.square[k];
    normal_ += at(g.normal), moment_ += at(g.moment), point_ += at(g.point);
  }
  Wrench result() const;

 private:
  double power_ = 0, weight_ = 0, square_ = 0;
  Vec3 normal_ = Vec3::Zero(), moment_ = Vec3::Zero(), point_ = Vec3::Zero();
};

// The features of one pair within two computed rows: corners of i against j, corners of j against
// i, edges. Triangles of one corner follow each other.
struct FeatureSet {
  std::size_t corners, corners_end, edges, edges_end;  // slots
  std::size_t word;                                    // number of the first corner feature's
  std::size_t of_i;                                    // corner features whose corner is one of i
};
Wrench smooth_maximum(const FeatureRow& corners, const FeatureRow& edges, const FeatureSet& set,
                      const FeatureWord* words, double reach);

// Closest point of triangle abc to p as weights of the corners (Ericson 2005, Real-Time Collision
// Detection, 5.1.5: Voronoi regions of corners, edges, face).
Vec3 closest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace trackbed::dem
