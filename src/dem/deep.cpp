// The mean over ways out and its gradient (deep.hpp):
//   M = sum w_a M_a / W,  W = sum w_a,
//   dM = (sum w_a dM_a + sum w_a M_a d(log w_a)) / W - M sum w_a d(log w_a) / W.
// Gradients are kept as what M changes by when j moves (N = -dM/dx_j) and when i turns about its
// centre (T). j may turn as well: that follows, since turning both together changes nothing.
#include "deep.hpp"

#include <cmath>

namespace trackbed::dem {

void DeepBlend::add(const WayOut& way, double length, double shortest, const Wrench& moved) {
  // Steep, so that the shortest way decides all but alone: with a half longer one the weight is
  // 6e-5. Less steep, ways through the whole core would count.
  constexpr double q = 24;
  // Over the shortest way, so that no power over- or underflows; the common factor drops out of the
  // mean (of its gradient too: it multiplies W and all terms alike). Crossed edges fade before they
  // are parallel and their axis loses its direction.
  const double weight = way.sine2 * std::pow(shortest / length, q);
  if (!(weight > 0)) return;
  const Vec3& n = way.slab.normal;
  const double grown = 1 + length / R_, M = grown * moved.M;
  // dM = grown dM_a + M_a / R dl, and the moved piece follows l n: dM_a has -N_a . (n dl + l dn).
  const double by_length = moved.M / R_ - grown * moved.N.dot(n);
  const Slope of_M{
      -grown * moved.N - by_length * n,
      grown * (moved.T - length * (way.swing.transpose() * moved.N)) - by_length * way.moment};
  // log w = log s - q log l + const, and l = apart - width: dl = -d width.
  const Slope of_log{q / length * n, q / length * way.moment + way.sharpens / way.sine2};
  weight_ += weight, M_ += weight * M;
  of_M_.add(weight, of_M), of_log_weight_.add(weight, of_log), of_both_.add(weight * M, of_log);
  x_ += weight * moved.x, spread_ += weight * moved.spread;
}

Wrench DeepBlend::result() const {
  Wrench w;
  if (!(weight_ > 0)) return w;
  const double over = 1 / weight_;
  w.M = over * M_;
  Slope slope;
  slope.add(over, of_M_), slope.add(over, of_both_), slope.add(-over * w.M, of_log_weight_);
  // N points from i to j: j moving away along it makes the overlap less.
  w.N = -slope.move, w.T = slope.turn;
  w.x = over * x_, w.spread = over * spread_;
  return w;
}

}  // namespace trackbed::dem
