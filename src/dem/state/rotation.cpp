// The rotation of a body about its principal axes in turn (Dullweber, Leimkuhler, McLachlan 1997,
// doi:10.1063/1.474310): the kinetic energy is split into its three parts L_a^2 / (2 I_a), each
// integrated exactly, in the order x y z y x, which is symmetric and so of second order. It keeps
// |q| to rounding, and the angular momentum in space axes is not changed. Rejected: Runge-Kutta on
// q and w, which drifts in |q| and in energy.
//
// Eight bodies at a time: for one body there would be a chain of ten divisions and two roots, each
// waiting for the previous one. A number of bodies that is no multiple of eight is padded: every
// body is processed in the same lanes, wherever it is stored.
#include "dem/state/rotation.hpp"

#include <algorithm>
#include <cmath>

#include "dem/lanes/rows.hpp"

namespace trackbed::dem {

namespace {

template <class Real>
[[gnu::always_inline]] inline Triple<Real> spin(const Real (&q)[4], const Triple<Real>& momentum,
                                                const Triple<Real>& over_inertia) {
  const Triple<Real> body = to_body(q, momentum);
  return turned(Triple<Real>{q[0], q[1], q[2]}, q[3],
                {body.x * over_inertia.x, body.y * over_inertia.y, body.z * over_inertia.z});
}

// tan(angle / 4) by its series, accurate to 1e-10 of the angle at 0.1 rad and much cheaper than the
// library's function, which is used for angles that a sub-step does not reach.
[[gnu::always_inline]] inline Lanes tangent_of_quarter(Lanes angle) {
  const Lanes x = 0.25 * angle, x2 = x * x;
  Lanes t = x * (all(1) + x2 * (all(1.0 / 3) + x2 * all(2.0 / 15)));
  if (any((angle > all(0.1)) | (angle < all(-0.1)))) [[unlikely]]
    for (std::size_t k = 0; k < lanes; ++k)
      if (!(std::abs(angle[k]) < 0.1)) t[k] = std::tan(x[k]);
  return t;
}

// Rotates the body frame by `angle` about its axis a and the angular momentum in it back. Rotation
// about one principal axis alone is exact: its momentum is constant, the others rotate about it. c,
// s: cosine and sine of half the angle from t = tan(angle / 4), so that c^2 + s^2 = 1 to rounding
// for any t: c = (1 - t^2) / (1 + t^2), s = 2 t / (1 + t^2).
template <int a>
[[gnu::always_inline]] inline void turn(Lanes (&q)[4], Lanes (&momentum)[3], Lanes angle) {
  constexpr int b = (a + 1) % 3, d = (a + 2) % 3;
  const Lanes t = tangent_of_quarter(angle), over = all(1) / (all(1) + t * t);
  const Lanes c = (all(1) - t * t) * over, s = 2 * t * over;
  // The product with (c, s about a), without zero terms.
  const Lanes qa = q[a], qb = q[b], qd = q[d], qw = q[3];
  q[3] = c * qw - s * qa, q[a] = c * qa + s * qw;
  q[b] = c * qb + s * qd, q[d] = c * qd - s * qb;
  const Lanes cos = c * c - s * s, sin = 2 * s * c;
  const Lanes lb = momentum[b], ld = momentum[d];
  momentum[b] = cos * lb + sin * ld, momentum[d] = cos * ld - sin * lb;
}

// Rotates the attitude about y by `angle`, in space axes: exact in a plane model, whose momentum
// does not rotate.
[[gnu::always_inline]] inline void turn_in_plane(Lanes (&q)[4], Lanes angle) {
  const Lanes t = tangent_of_quarter(angle), over = all(1) / (all(1) + t * t);
  const Lanes c = (all(1) - t * t) * over, s = 2 * t * over;
  const Lanes x = q[0], y = q[1], z = q[2], w = q[3];
  q[0] = c * x + s * z, q[1] = c * y + s * w, q[2] = c * z - s * x, q[3] = c * w - s * y;
}

// Removes rounding errors only: every rotation keeps |q|.
[[gnu::always_inline]] inline void normalise(Lanes (&q)[4]) {
  const Lanes norm = all(1) / root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (Lanes& v : q) v = v * norm;
}

// The attitude after dt; over_inertia: 1/I of the principal axes.
[[gnu::always_inline]] inline void rotate(Lanes (&q)[4], const Triple<Lanes>& momentum,
                                          const Triple<Lanes>& over_inertia, double dt) {
  const Triple<Lanes> body = to_body(q, momentum);
  Lanes l[3] = {body.x, body.y, body.z};
  turn<0>(q, l, 0.5 * dt * l[0] * over_inertia.x);
  turn<1>(q, l, 0.5 * dt * l[1] * over_inertia.y);
  turn<2>(q, l, dt * l[2] * over_inertia.z);
  turn<1>(q, l, 0.5 * dt * l[1] * over_inertia.y);
  turn<0>(q, l, 0.5 * dt * l[0] * over_inertia.x);
  normalise(q);
}

// Eight consecutive bodies.
struct Bodies {
  Vec4 *x, *q, *w;
  const Vec4 *v, *l, *inertia, *reference_x, *reference_q;
  const double* slow;
};

// m, displacement of a surface point since the reference; m/s, of those that are slow.
struct Motions {
  Lanes displacement, speed;
};

[[gnu::always_inline]] inline void store(const Lanes4& v, Vec4* to) {
  to_rows(v, [to](std::size_t k, Four row) { put(to[k], row); });
}

template <bool plane>
Motions drift_and_rotate(const Bodies& b, double dt) {
  const Lanes4 v = rows(b.v), q0 = rows(b.q), l = rows(b.l), inertia = rows(b.inertia);
  Lanes4 x = rows(b.x);
  x.x = x.x + dt * v.x, x.y = x.y + dt * v.y, x.z = x.z + dt * v.z;
  store(x, b.x);
  Lanes q[4] = {q0.x, q0.y, q0.z, q0.w};
  Triple<Lanes> w{all(0), l.y / inertia.y, all(0)};
  if constexpr (plane) {
    turn_in_plane(q, dt * w.y);
    normalise(q);
  } else {
    const Triple<Lanes> momentum{l.x, l.y, l.z};
    const Triple<Lanes> over_inertia{all(1) / inertia.x, all(1) / inertia.y, all(1) / inertia.z};
    rotate(q, momentum, over_inertia, dt);
    w = spin(q, momentum, over_inertia);
  }
  store({q[0], q[1], q[2], q[3]}, b.q);
  store({w.x, w.y, w.z, all(0)}, b.w);
  const Lanes4 from = rows(b.reference_x), before = rows(b.reference_q);
  const Lanes dx = x.x - from.x, dy = x.y - from.y, dz = x.z - from.z;
  const Lanes cx = q[0] - before.x, cy = q[1] - before.y, cz = q[2] - before.z,
              cw = q[3] - before.w;
  // |q - q0| = 2 sin(angle/4) or more; 2.1 covers angles up to 1 rad.
  Motions motions;
  motions.displacement =
      root(dx * dx + dy * dy + dz * dz) + 2.1 * x.w * root(cx * cx + cy * cy + cz * cz + cw * cw);
  motions.speed = all(0);
  if (b.slow) {
    Lanes slow;
    for (std::size_t k = 0; k < lanes; ++k) slow[k] = b.slow[k];
    motions.speed = slow * (root(v.x * v.x + v.y * v.y + v.z * v.z) +
                            x.w * root(w.x * w.x + w.y * w.y + w.z * w.z));
  }
  return motions;
}

// Fewer than eight: in a copy, with the last one repeated.
template <bool plane>
Motions drift_and_rotate_rest(const Bodies& b, std::size_t count, double dt) {
  Vec4 x[lanes], q[lanes], w[lanes], v[lanes], l[lanes], inertia[lanes], from[lanes], before[lanes];
  double slow[lanes];
  for (std::size_t k = 0; k < lanes; ++k) {
    const std::size_t n = std::min(k, count - 1);
    x[k] = b.x[n], q[k] = b.q[n], v[k] = b.v[n], l[k] = b.l[n], inertia[k] = b.inertia[n];
    from[k] = b.reference_x[n], before[k] = b.reference_q[n], slow[k] = b.slow ? b.slow[n] : 0;
  }
  const Motions motions =
      drift_and_rotate<plane>({x, q, w, v, l, inertia, from, before, b.slow ? slow : nullptr}, dt);
  std::copy_n(x, count, b.x), std::copy_n(q, count, b.q), std::copy_n(w, count, b.w);
  return motions;
}

// As `not_below`, in each lane.
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes most) {
  // NOLINTNEXTLINE(misc-redundant-expression): true of what is not a number
  return select((a <= most) | (most != most), most, a);
}

template <bool plane>
LargestMotion all_drift_and_rotate(State& state, double dt, const Reference& since) {
  Lanes displacement = all(0), speed = all(0);
  for (std::size_t b = 0; b < state.own; b += lanes) {
    const Bodies bodies{&state.x[b], &state.q[b], &state.w[b],
                        &state.v[b], &state.l[b], &state.inertia[b],
                        &since.x[b], &since.q[b], since.slow ? since.slow + b : nullptr};
    const std::size_t count = std::min(lanes, state.own - b);
    const Motions moved = count == lanes ? drift_and_rotate<plane>(bodies, dt)
                                         : drift_and_rotate_rest<plane>(bodies, count, dt);
    displacement = larger(moved.displacement, displacement), speed = larger(moved.speed, speed);
  }
  LargestMotion largest;
  for (std::size_t k = 0; k < lanes; ++k) {
    largest.displacement = not_below(displacement[k], largest.displacement);
    largest.slow_speed = not_below(speed[k], largest.slow_speed);
  }
  return largest;
}

}  // namespace

double inverse_mass_of_turning(const State& state, std::size_t b, const Triple<double>& lever) {
  if (state.held[b] != 0) return 0;
  const Vec4 &q = state.q[b], &moments = state.inertia[b];
  const double attitude[4] = {q.x, q.y, q.z, q.w};
  const Triple<double> body = to_body(attitude, lever);
  return body.x * body.x / moments.x + body.y * body.y / moments.y + body.z * body.z / moments.z;
}

double largest_inverse_moment(const State& state, std::size_t b) {
  const Vec4& moments = state.inertia[b];
  return state.held[b] != 0 ? 0 : 1 / std::min({moments.x, moments.y, moments.z});
}

Vec4 spin_of(const Vec4& attitude, const Vec4& momentum, const Vec4& inertia) {
  const double q[4] = {attitude.x, attitude.y, attitude.z, attitude.w};
  const Triple<double> over_inertia{1 / inertia.x, 1 / inertia.y, 1 / inertia.z};
  const Triple<double> w =
      spin(q, Triple<double>{momentum.x, momentum.y, momentum.z}, over_inertia);
  return {w.x, w.y, w.z, 0};
}

LargestMotion drift_and_rotate(State& state, Dimension dimension, double dt,
                               const Reference& since) {
  return dimension == Dimension::plane ? all_drift_and_rotate<true>(state, dt, since)
                                       : all_drift_and_rotate<false>(state, dt, since);
}

}  // namespace trackbed::dem
