// Rows of features, and the smooth maximum of one pair of them (features.hpp).
#include "dem/shape/features.hpp"

#include <cmath>

#include "dem/shape/feature_kernels.hpp"

namespace trackbed::dem {

void FeatureRow::compute_corners() {
  for (std::size_t n = 0; n * lanes < size_; ++n) corner_and_triangle(groups_[n]);
}

void FeatureRow::compute_edges() {
  for (std::size_t n = 0; n * lanes < size_; ++n) edge_and_edge(groups_[n]);
}

// The sums of `finish` for one feature, for single contacts (surfaces).
void Overlaps::add(double delta, const Vec3& n, const Vec3& x) {
  if (!(delta > 0)) return;
  const double p2 = delta * delta, p4 = p2 * p2, p5 = p4 * delta;
  const Triple<double> at = triple(x), normal = p5 * triple(n), point = p5 * at;
  power_ += p4 * p2, weight_ += p5, square_ += dot(at, point);
  normal_ += vec3(normal), moment_ += vec3(cross(at, normal)), point_ += vec3(point);
}

// M = (sum delta^6)^(1/6), s_k = (delta_k / M)^5: N and T are the gradient of M.
Wrench Overlaps::result() const {
  Wrench w;
  // No overlap, or one below 1e-50 m, whose powers underflow.
  if (!(power_ > 1e-300)) return w;
  w.M = std::cbrt(std::sqrt(power_));
  const double factor = w.M / power_;  // 1 / M^5
  w.N = factor * normal_, w.T = factor * moment_;
  w.x = point_ / weight_;
  // Mean square less square of the mean: at a single point rounding may give a negative number.
  const double spread = square_ / weight_ - w.x.squaredNorm();
  w.spread = spread > 0 ? spread : 0;
  return w;
}

// Cost: the sums only, distances are computed before. In the order of the set, so that the result
// is bitwise identical on every rank.
Wrench smooth_maximum(const FeatureRow& corners, const FeatureRow& edges, const FeatureSet& set,
                      const FeatureWord* words, double reach) {
  Overlaps overlaps;
  double closest = 1e300;
  const auto add = [&](const FeatureRow& row, std::size_t slot) {
    const double d = row.distance(slot);
    // Of all features, in contact or not: it determines how long the pair need not be checked.
    closest = d < closest ? d : closest;
    if (d < reach) overlaps.add(row, slot);
  };
  words += set.word;
  const std::size_t count = set.corners_end - set.corners;
  for (std::size_t k = 0; k < count;) {
    // The distance of a corner to the other core is the least to its triangles.
    std::size_t best = set.corners + k;
    const std::uint8_t corner = words[k][0];
    const bool of_i = k < set.of_i;
    for (++k; k < count && words[k][0] == corner && (k < set.of_i) == of_i; ++k)
      if (corners.distance(set.corners + k) < corners.distance(best)) best = set.corners + k;
    add(corners, best);
  }
  for (std::size_t slot = set.edges; slot < set.edges_end; ++slot) add(edges, slot);
  Wrench wrench = overlaps.result();
  wrench.closest = closest;
  return wrench;
}

// For infrequent use; feature rows have the same without branches. Triangles without area are
// allowed: b = c is a segment, a = b = c a point.
Vec3 closest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {1 - v - w, v, w};
}

}  // namespace trackbed::dem
