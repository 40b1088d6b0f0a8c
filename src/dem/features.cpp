#include "features.hpp"

#include <cmath>

namespace trackbed::dem {

namespace {

[[gnu::always_inline]] inline double clamped(double t) {
  const double low = t > 0 ? t : 0;
  return low < 1 ? low : 1;
}

// Lengths of degenerate features are zero: keeps the quotient finite.
[[gnu::always_inline]] inline double over(double length) {
  return 1 / (length > 1e-300 ? length : 1e-300);
}

// Normal from i to j, distance and point of contact from the closest point of i and the vector w
// from it to the closest point of j.
[[gnu::always_inline]] inline void finish(FeatureGroup& g, std::size_t k, const double (&on_i)[3],
                                          const double (&w)[3]) {
  const double d = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const double inverse = over(d), inward = g.half[k] + 0.5 * d;
  g.d[k] = d;
  for (int a = 0; a < 3; ++a) {
    const double n = w[a] * inverse;
    g.n[a][k] = n;
    g.x[a][k] = on_i[a] + inward * n;
  }
}

// Corner p and triangle abc: the foot on the plane if it lies inside, else the closest of the
// closest points of the three sides. No branches, so that the loop runs on all lanes at once.
[[gnu::always_inline]] inline void corner_and_triangle(FeatureGroup& g, std::size_t k) {
  double ab[3], ac[3], ap[3], bc[3], q[3], w[3], on_i[3];
  for (int a = 0; a < 3; ++a) {
    ap[a] = g.p[0][a][k] - g.p[1][a][k];
    ab[a] = g.p[2][a][k] - g.p[1][a][k];
    ac[a] = g.p[3][a][k] - g.p[1][a][k];
    bc[a] = g.p[3][a][k] - g.p[2][a][k];
  }
  const auto dot = [](const double(&u)[3], const double(&v)[3]) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  const double b2 = dot(ab, ab), c2 = dot(ac, ac), bc2 = dot(bc, bc), mixed = dot(ab, ac);
  const double area = b2 * c2 - mixed * mixed;
  const double v = c2 * d1 - mixed * d2, u = b2 * d2 - mixed * d1;
  const bool inside = v > 0 && u > 0 && v + u < area;
  const double t_ab = clamped(d1 * over(b2)), t_ac = clamped(d2 * over(c2));
  const double t_bc = clamped((dot(bc, ap) - dot(bc, ab)) * over(bc2));
  double l_ab = 0, l_ac = 0, l_bc = 0;  // squared distances
  for (int a = 0; a < 3; ++a) {
    const double e = ap[a] - t_ab * ab[a], f = ap[a] - t_ac * ac[a];
    const double h = ap[a] - ab[a] - t_bc * bc[a];
    l_ab += e * e, l_ac += f * f, l_bc += h * h;
  }
  const bool first = l_ab <= l_ac && l_ab <= l_bc, second = !first && l_ac <= l_bc;
  const double scale = over(area);
  // The closest point is a + x ab + y ac.
  const double x_side = first ? t_ab : (second ? 0.0 : 1 - t_bc);
  const double y_side = first ? 0.0 : (second ? t_ac : t_bc);
  const double x = inside ? v * scale : x_side, y = inside ? u * scale : y_side;
  const double side = g.side[k];
  for (int a = 0; a < 3; ++a) {
    q[a] = x * ab[a] + y * ac[a];
    w[a] = side * (q[a] - ap[a]);
    on_i[a] = side > 0 ? g.p[0][a][k] : g.p[1][a][k] + q[a];
  }
  finish(g, k, on_i, w);
}

// Edges p0 p1 of i and p2 p3 of j (Ericson 2005, 5.1.9), without branches: the second clamping
// corrects the first.
[[gnu::always_inline]] inline void edge_and_edge(FeatureGroup& g, std::size_t k) {
  double d1[3], d2[3], r[3], on_i[3], w[3];
  for (int a = 0; a < 3; ++a) {
    d1[a] = g.p[1][a][k] - g.p[0][a][k];
    d2[a] = g.p[3][a][k] - g.p[2][a][k];
    r[a] = g.p[0][a][k] - g.p[2][a][k];
  }
  const auto dot = [](const double(&u)[3], const double(&v)[3]) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  };
  const double a = dot(d1, d1), e = dot(d2, d2), b = dot(d1, d2), c = dot(d1, r), f = dot(d2, r);
  const double det = a * e - b * b;
  constexpr double parallel = 1e-14;  // squared sine below which any start is as good
  const double s0 = det > parallel * a * e ? clamped((b * f - c * e) * over(det)) : 0.0;
  const double t = clamped((b * s0 + f) * over(e));
  const double s = clamped((b * t - c) * over(a));
  for (int m = 0; m < 3; ++m) {
    on_i[m] = g.p[0][m][k] + s * d1[m];
    w[m] = g.p[2][m][k] + t * d2[m] - on_i[m];
  }
  finish(g, k, on_i, w);
}

}  // namespace

void FeatureRow::compute_corners() {
  for (std::size_t n = 0; n * lanes < size_; ++n) {
    FeatureGroup& g = groups_[n];
#pragma omp simd
    for (std::size_t k = 0; k < lanes; ++k) corner_and_triangle(g, k);
  }
}

void FeatureRow::compute_edges() {
  for (std::size_t n = 0; n * lanes < size_; ++n) {
    FeatureGroup& g = groups_[n];
#pragma omp simd
    for (std::size_t k = 0; k < lanes; ++k) edge_and_edge(g, k);
  }
}

namespace {

// Collects the overlaps of one pair; few, so they are kept on the stack until M is known.
class Overlaps {
 public:
  explicit Overlaps(double reach) : reach_(reach) {}
  void add(const FeatureRow& row, std::size_t slot) {
    const double d = row.distance(slot);
    wrench_.closest = d < wrench_.closest ? d : wrench_.closest;
    const double delta = reach_ - d;
    if (!(delta > 0)) return;
    // Every contribution over delta^7 only: the common factor M^-7 comes at the end.
    const double p2 = delta * delta, p4 = p2 * p2, p7 = p4 * p2 * delta;
    sum_ += p4 * p4;
    weight_ += p7;
    const Vec3 n = row.normal(slot), x = row.contact(slot);
    wrench_.N += p7 * n;
    wrench_.T += p7 * x.cross(n);
    wrench_.x += p7 * x;
    wrench_.spread += p7 * x.squaredNorm();
  }
  Wrench result() {
    if (!(sum_ > 1e-300)) return Wrench{.closest = wrench_.closest};
    const double quarter = std::sqrt(std::sqrt(sum_));  // M^2
    wrench_.M = std::sqrt(quarter);
    const double share = wrench_.M / sum_;  // 1 / M^7
    wrench_.N *= share, wrench_.T *= share;
    wrench_.x /= weight_;
    const double spread = wrench_.spread / weight_ - wrench_.x.squaredNorm();
    wrench_.spread = spread > 0 ? spread : 0;
    return wrench_;
  }

 private:
  double reach_, sum_ = 0, weight_ = 0;
  Wrench wrench_;
};

}  // namespace

Wrench smooth_maximum(const FeatureRow& corners, const FeatureRow& edges, const FeatureSet& set,
                      const FeatureWord* words, double reach) {
  Overlaps overlaps(reach);
  words += set.word;
  const std::size_t count = set.corners_end - set.corners;
  for (std::size_t k = 0; k < count;) {
    // The distance of a corner to the other core is the least to its triangles.
    std::size_t best = set.corners + k;
    const std::uint8_t corner = words[k][0];
    const bool of_i = k < set.of_i;
    for (++k; k < count && words[k][0] == corner && (k < set.of_i) == of_i; ++k)
      if (corners.distance(set.corners + k) < corners.distance(best)) best = set.corners + k;
    overlaps.add(corners, best);
  }
  for (std::size_t slot = set.edges; slot < set.edges_end; ++slot) overlaps.add(edges, slot);
  return overlaps.result();
}

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
