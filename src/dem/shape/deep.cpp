// The mean over directions of separation and its gradient (deep.hpp):
//   M = sum w_a M_a / W,  W = sum w_a,
//   dM = (sum w_a dM_a + sum w_a M_a d(log w_a)) / W - M sum w_a d(log w_a) / W.
// Gradients are stored as the change of M when j moves (N = -dM/dx_j) and when i rotates about its
// centre (T). The gradient for a rotation of j follows, since rotating both together changes
// nothing.
#include "dem/shape/deep.hpp"

#include <cmath>

namespace trackbed::dem {

void DeepBlend::add(const SeparationDirection& direction, double length, double shortest,
                    const Wrench& moved) {
  // Steep, so that the shortest direction is nearly alone decisive: for one half longer the weight
  // is 6e-5. With a smaller exponent directions through the whole core would count.
  constexpr double q = 24;
  // Over the shortest one, so that no power over- or underflows; the common factor cancels in the
  // mean (in its gradient too: it multiplies W and all terms alike). The weight of crossed edges
  // vanishes before they are parallel and their axis is undefined.
  const double weight = direction.sine2 * std::pow(shortest / length, q);
  if (!(weight > 0)) return;
  const Vec3& n = direction.slab.normal;
  const double grown = 1 + length / R_, M = grown * moved.M;
  // dM = grown dM_a + M_a / R dl, and the displaced piece follows l n: dM_a has -N_a . (n dl + l
  // dn).
  const double by_length = moved.M / R_ - grown * moved.N.dot(n);
  const Slope of_M{-grown * moved.N - by_length * n,
                   grown * (moved.T - length * (direction.swing.transpose() * moved.N)) -
                       by_length * direction.moment};
  // log w = log s - q log l + const, and l = apart - width: dl = -d width.
  const Slope of_log{q / length * n,
                     q / length * direction.moment + direction.sharpens / direction.sine2};
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
  // N points from i to j: if j moves away along it, the overlap decreases.
  w.N = -slope.move, w.T = slope.turn;
  w.x = over * x_, w.spread = over * spread_;
  return w;
}

}  // namespace trackbed::dem
