// The force of a contact as a pure function of overlap, velocities, history and parameters, for one
// contact (Real = double) or eight in lanes (Real = Lanes) with the same roundings.
//
// linear: F_n = k_n delta + c_n v_n, F_s = -k_s xi - c_s v_t, |F_s| <= mu F_n
//   (Cundall, Strack 1979, doi:10.1680/geot.1979.29.1.47), c = 2 zeta sqrt(m_eff k).
// hertz: with the contact size a = sqrt(R delta), k_n = 4/3 E* a and k_s = 8 G* a (Hertz 1882;
//   Mindlin 1949), damping 2 sqrt(5/6) beta sqrt(S m_eff), S = 2 E* a (Tsuji et al. 1992,
//   doi:10.1016/0032-5910(92)88030-L), beta such that a collision has the wanted restitution.
//
// No closed motion of a contact returns more work than it received, but for the error of the steps:
// - The tangential spring F = k_s xi of a Hertz contact changes with the overlap. Where k_s rises
//   the force is kept, so that xi shrinks by k_old / k_new; where it falls xi is kept and the force
//   falls with it (Thornton, Cummins, Cleary 2013, doi:10.1016/j.powtec.2012.08.012). Both take
//   energy out of the spring, 1/2 k_s xi^2, and none puts any in.
// - Coulomb's limit cuts the spring and then the sum of spring and dashpot, which leaves the spring
//   its stretch: however strong the dashpot, friction is the limit while a contact slides. Cutting
//   is a projection P onto the ball of forces within the limit. It takes energy from the spring,
//   and since the spring's force lies in the ball, the dashpot only dissipates: (P(k xi + c v) - k
//   xi) . v >= 0. Rejected: no dashpot while the spring slips. Where many contacts are at their
//   limit, one that acts in one step and not in the next lets errors of rounding grow.
// - Where a contact opens or closes within a step, the normal spring is corrected such that the
//   step's work is that of the spring (`spring_force`).
// Other codes and what they lose: docs/decisions/contact_laws.md.
#pragma once

#include "dem/lanes/lanes.hpp"

namespace trackbed::dem {

// One pair of materials.
template <class Real>
struct Springs {
  Real k_n{}, k_s{};  // N/m; hertz: over the contact size a, Pa
  Real c_n{}, c_s{};  // over sqrt(m_eff): 2 zeta sqrt(k); hertz: over sqrt(a m_eff)
  Real mu{};
  Real least{};  // N, F_n >= least: 0 without attraction, else -infinity
  Real hertz{};  // 1: stiffnesses grow with a; 0: linear
};

// At one overlap. m_eff = m_i m_j / (m_i + m_j), kg; against a surface m_i, since what is behind it
// is heavy.
template <class Real>
struct Coefficients {
  Real k_n, k_s, c_n, c_s, mu, least;
  Real size;  // a, m; 1 for linear springs
};

// R: 1/R = 1/R_i + 1/R_j (m); root_mass: sqrt(m_eff). `any_hertz` false: no law is, and the roots
// are left out.
template <bool any_hertz, class Real>
[[gnu::always_inline]] inline Coefficients<Real> coefficients(const Springs<Real>& s, Real delta,
                                                              Real root_mass, Real radius) {
  if constexpr (any_hertz) {
    const Real one = Real{} + 1.0;
    const Real a = select(s.hertz > 0, root(radius * larger(delta, Real{})), one);
    const Real damping = root(a) * root_mass;
    return {s.k_n * a, s.k_s * a, s.c_n * damping, s.c_s * damping, s.mu, s.least, a};
  } else {
    return {s.k_n, s.k_s, s.c_n * root_mass, s.c_s * root_mass, s.mu, s.least, Real{} + 1.0};
  }
}

// What a contact is computed from: unit normal n from i to j (surface: into it), velocity v of i
// against j at the contact (m/s), overlap (m), twist: mean spin of the two about n (rad/s).
template <class Real>
struct Touch {
  Triple<Real> n, v;
  Real delta, twist;
};

template <class Real, std::size_t n>
[[gnu::always_inline]] inline Real polynomial(const double (&c)[n], Real x) {
  Real sum = Real{} + c[n - 1];
  for (std::size_t k = n - 1; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

// The force of a Hertz spring, F = K delta^1.5, in the step in which the contact closes or opens,
// over K t^1.5. It is chosen such that all steps of the contact together do the spring's work.
//   theta = delta / t, in 0..1, where t is the travel of one step (m);
//   e = dt^2 K sqrt(t) / m_eff, the fraction of the speed that K t^1.5 removes in one step.
//
// Derivation. The work is a sum over whole steps. By the formula of Euler and Maclaurin for an
// algebraic endpoint (Navot 1961, doi:10.1002/sapm1961401271) it differs from the integral by terms
// of the two ends only. In units of t, the overlaps x(n) after a free approach follow
//   x(n) = n + e X(n) + O(e^2),  X(n + 1) - 2 X(n) + X(n - 1) = -n^1.5,
// so that X(n) = n Z(-3/2, n) - Z(-5/2, n). Z is Hurwitz's zeta function; n is counted from where
// x = 0. With x = theta in the closing step, the force that makes the difference vanish is
//   g_0 + e g_1 + O(e^2),  g_0 = -Z(-3/2, 1 + theta),  g_1 = 3/2 Z(-1/2, 1 + theta) X(theta) - U,
// where U is 3/2 times the sum over n > 0 of sqrt(theta + n) X(theta + n), its divergent part taken
// by Z. When the contact closes, t is the travel of the step before. Opening is the mirror image,
// with the travel of the step after, which is not yet known: the travel under the force K delta^1.5
// is taken for it, which adds (g_0 - theta^1.5) (3/2 g_0 - theta g_0') to g_1.
// The polynomials are fits on 0..1; they are right to 1e-8, 2e-8 and 3e-5.
template <class Real, class Test>
[[gnu::always_inline]] inline Real hertz_onset(Real theta, Real e, Test closes) {
  constexpr double zeroth[] = {0.02548521102,  0.3118281237,  0.5476597213,    0.1630440743,
                               -0.03044568576, 0.01072309566, -0.003383020826, 0.0005736895788};
  constexpr double closing[] = {0.0001122760739, 0.01950982229,   0.0002183532768,
                                -0.09186607972,  0.0001141661282, 0.07997077885};
  constexpr double opening[] = {0.00111702391, 0.03026279809, -0.05310199237,
                                -0.1014750637, 0.2056594391,  -0.08137581436};
  const Real first = select(closes, polynomial(closing, theta), polynomial(opening, theta));
  return polynomial(zeroth, theta) + e * first;
}

// The normal spring, in a step.
template <class Real>
struct NormalSpring {
  Real force;     // N
  Real linear{};  // 1, or 0 of Hertz's law
  Real mass;      // kg, effective for a force along the normal
};

// How the overlap delta (m) changes in a step: `rate`, the closing velocity of the half step before
// (m/s), and `turning`, the distance by which the rotation of the line of centres alone parts the
// two in a step (m).
template <class Real>
struct OverlapMotion {
  Real delta, rate, turning{};
};

// Mass by which the force of a spring changes the rate of its overlap, kg: a lower bound, and
// `exact(may_end)`, which is called if a contact may open or close, for those that may.
template <class Real, class Exact>
struct EndMass {
  Real least;
  Exact exact;
};
// Of bodies that the force does not rotate, or whose mass is known.
template <class Real>
[[gnu::always_inline]] inline auto end_mass(Real mass) {
  const auto exact = [mass](auto) { return mass; };
  return EndMass<Real, decltype(exact)>{mass, exact};
}

// The normal spring's force.
//
// In each step velocity Verlet adds the work (F_0 + F_1)/2 (x_1 - x_0) to the kinetic energy. For a
// linear spring that is exact, except in the steps in which the contact closes or opens. In those
// the force is chosen such that the two steps around it do the spring's work. With the overlap
// delta, the travel s = |rate| dt of the step before and b = dt^2 / m_eff:
//   closing: F (2 s - b F) = k delta (delta + s - p - b F), where s - b F is the travel of the next
//   step, opening: F (2 s + b F) = k delta (delta + s - p).
// Here p is `turning`: two centres with the velocity v_t across their distance d are v_t^2 dt^2 /
// (2 d) farther apart one step before and one step after. In between, both steps cancel it. For
// Hertz's law, whose force is small at the ends, it is left out.
// A head-on elastic collision of two bodies then keeps its energy to rounding, an oblique one of
// two balls to 2.5e-10 (`bounces_test`). For a Hertz spring the sum is not exact in between either;
// `hertz_onset` corrects all of it at the two ends. The error of a collision of 50 steps is then
// 1e-11 of the energy (6e-5 without) and of order 7.5 in the step. The force of a contact that
// neither closes nor opens is not changed.
//
// A Hertz contact has one corrected step at each end, which is the one with theta in 0..1. Where
// two bodies touch just at the end of a step, rounding would decide whether two steps or none are
// corrected (error 5e-5 of the energy). The interval is therefore `edge`..1 + `edge`, whose
// ends round numbers in decks do not reach.
inline constexpr double edge = 1e-5;

template <bool any_hertz, class Real, class Exact>
[[gnu::always_inline]] inline NormalSpring<Real> spring_force(const Springs<Real>& spring,
                                                              const Coefficients<Real>& c,
                                                              const OverlapMotion<Real>& motion,
                                                              const EndMass<Real, Exact>& masses,
                                                              Real radius, double dt) {
  const Real delta = motion.delta, rate = motion.rate, turning = motion.turning;
  const Real force = c.k_n * delta;
  const Real s = larger(rate, -rate) * dt;
  const auto closes = rate > 0;
  // Whether the overlap is below `part` of the travel of a step. Of eight near pairs, many are not
  // in contact: they need no correction.
  const auto ends = [&](double part, const Real& travel, const Real& mass) {
    const Real from_end = delta - part * travel;
    const auto opens = (rate <= 0) & (from_end * mass < (part * dt * dt) * force);
    return (delta >= 0) & (opens | (closes & (from_end < 0)));
  };
  Real is_linear = Real{} + 1.0;
  if constexpr (any_hertz) is_linear = select(spring.hertz > 0, Real{}, is_linear);
  const auto may_end = ends(any_hertz ? 1 + edge : 1, s + turning, masses.least);
  if (!any(may_end)) return {force, is_linear, masses.least};
  const Real mass = masses.exact(may_end);
  const Real some_mass = larger(mass, Real{} + 1e-300);
  const Real b = (dt * dt) * c.k_n / some_mass;
  const Real area = delta * larger(delta + s - turning, Real{}), sum = 2.0 * s + b * delta;
  const Real closing = 2.0 * area / (sum + root(larger(sum * sum - 4.0 * b * area, Real{})));
  const Real opening = area / larger(s + root(s * s + b * area), Real{} + 1e-300);
  const Real linear =
      select(ends(1, s + turning, mass), c.k_n * select(closes, closing, opening), force);
  if constexpr (any_hertz) {
    const Real travel = larger(select(closes, s, s + b * delta), Real{} + 1e-300);
    const Real theta = smaller(delta / travel, Real{} + (1 + edge));
    const Real stiffness = spring.k_n * root(radius * travel);
    // Far below 1 in every step that is stable.
    const Real e = smaller((dt * dt) * stiffness / some_mass, Real{} + 1.0);
    const Real onset = stiffness * travel * hertz_onset(theta, e, closes);
    const Real hertz = select(ends(1 + edge, s, mass) & (theta > edge), onset, force);
    return {select(spring.hertz > 0, hertz, linear), is_linear, mass};
  } else {
    return {linear, is_linear, mass};
  }
}

// Ratio of a spring's stiffness in the step before to that now.
template <class Real>
[[gnu::always_inline]] inline Real softening(Real before, Real now) {
  return before / larger(now, Real{} + 1e-300);
}
// How much of its stretch remains.
template <class Real>
[[gnu::always_inline]] inline Real kept(Real softening) {
  return smaller(softening, Real{} + 1.0);
}

// Energy that a contact dissipates in a step, J: by friction (sliders, and springs whose stiffness
// changes) and by dashpots. It closes the balance of energy up to errors of the time step.
template <class Real>
struct Dissipation {
  Real friction{}, damping{};
};
template <class Real>
[[gnu::always_inline]] inline Dissipation<Real> operator+(const Dissipation<Real>& a,
                                                          const Dissipation<Real>& b) {
  return {a.friction + b.friction, a.damping + b.damping};
}

// By how much a force must be multiplied to be no larger than the limit.
template <class Vector, class Real>
[[gnu::always_inline]] inline Real within(const Vector& force, Real limit) {
  const Real square = dot(force, force);
  const auto beyond = square > limit * limit;
  if (!any(beyond)) return Real{} + 1.0;
  return select(beyond, limit / root(larger(square, Real{} + 1e-300)), Real{} + 1.0);
}

// A spring with dashpot in the tangent plane, whose force friction limits.
template <class Real>
struct Slider {
  Real k, c;       // N/m, Ns/m
  Real limit;      // N
  Real softening;  // since the step before
};

// What is predicted for a slider in the next step.
template <class Real>
struct NextStep {
  Real limit;  // N, half of the predicted limit of friction; of Hertz contacts infinite
  Real mass;   // kg, effective for a force along the normal
};

// The factor of a slider's force while it drives the motion v and its stretch xi passes zero in the
// next step. The trapezoid's work is exact also in that step, provided that the force of the next
// step may act: it takes back what this step's force does too much. If the limit of the next step
// cuts that force, because the contact is about to open, up to k (v dt)^2 / 8 would be gained each
// time. The force is then multiplied by the stretch over the travel of one step. That travel
// includes what the force itself adds to the velocity: the surface of a solid sphere yields to a
// tangential force 7/2 times as much as to a normal one (rolling: 5/2 times).
template <class Real>
[[gnu::always_inline]] inline Real remaining(const Triple<Real>& force, const Triple<Real>& v,
                                             const Triple<Real>& xi, Real k,
                                             const NextStep<Real>& next, double dt) {
  const Real stretch = root(dot(xi, xi)), tiny = Real{} + 1e-300;
  const Real added = (3.5 * dt * dt) * k * stretch / larger(next.mass, tiny);
  const Real travel = root(dot(v, v)) * dt + added;
  const auto ends = (dot(force, v) > 0) & (next.limit < k * (travel - stretch));
  return select(ends, stretch / larger(travel, tiny), Real{} + 1.0);
}

// What the limit leaves of a spring and its dashpot: the fraction of the stretch that remains, and
// their force. `Vector`: a vector in the plane of contact, or an `InFace`.
template <class Real, class Vector>
struct Limited {
  Real stuck;
  Vector force;
};

template <class Real, class Vector>
[[gnu::always_inline]] inline Limited<Real, Vector> limited(const Slider<Real>& s,
                                                            const Vector& stretch,
                                                            const Vector& rate) {
  const Vector spring = s.k * stretch;
  const Real stuck = within(spring, s.limit);
  const Vector both = stuck * spring + s.c * rate;
  // Without a spring the stretch has no use and is zero.
  return {select(s.k > 0, stuck, Real{}), -within(both, s.limit) * both};
}

// The stretch xi (m) after a step dt at the sliding velocity v (m/s). The part of xi along the new
// normal is taken off (the plane has turned), the rest turns with the contact, in a way that never
// lengthens it. The increment, whose velocity is that of half a step before, turns by half as much:
// unturned, it made a lasting contact gain energy.
template <class Real>
[[gnu::always_inline]] inline Triple<Real> stretched(const Triple<Real>& xi, Real kept,
                                                     const Triple<Real>& n, const Triple<Real>& v,
                                                     Real twist, double dt) {
  const Triple<Real> plane = xi - dot(xi, n) * n;
  const Real turn = twist * dt;
  const Real shrink = kept * (1.0 - 0.5 * (turn * turn));  // of |plane + turn n x plane|
  return shrink * (plane + turn * cross(n, plane)) + dt * (v + (0.5 * turn) * cross(n, v));
}

// The force where the stretch xi may pass zero before the contact opens, see `remaining`.
template <class Real>
[[gnu::always_inline]] inline Triple<Real> before_end(const Triple<Real>& force,
                                                      const Slider<Real>& s,
                                                      const NextStep<Real>& next,
                                                      const Triple<Real>& v, const Triple<Real>& xi,
                                                      double dt) {
  // Whether the limit may cut what two steps stretch; with a limit of 0 there is no force.
  const Real reach = 2.0 * dt * s.k;
  const auto near_end = (next.limit * next.limit < reach * reach * dot(v, v)) & (s.limit > 0);
  if (!any(near_end)) return force;
  return select(near_end, remaining(force, v, xi, s.k, next, dt), Real{} + 1.0) * force;
}

// What a slider dissipates in a step at the rate v: the trapezoid's work of its spring less what
// the spring stores, and the work of the rest of its force. `moved`: the stretch before the limit,
// of which `stuck` remains.
template <class Real, class Vector>
[[gnu::always_inline]] inline Dissipation<Real> dissipation(const Slider<Real>& s, Real stuck,
                                                            const Vector& moved, const Vector& v,
                                                            const Vector& force, double dt) {
  const Real slip = (1.0 + stuck) * dot(moved, moved) - dt * dot(v, moved);
  return {0.5 * s.k * (1.0 - stuck) * slip, -dt * dot(force + (s.k * stuck) * moved, v)};
}
// J, that a change of stiffness takes from a spring.
template <class Real>
[[gnu::always_inline]] inline Real softening_loss(Real k, Real softening, Real square) {
  const Real remains = kept(softening);
  return 0.5 * k * (softening - remains * remains) * square;
}

// N, and what is dissipated.
template <class Real>
struct Friction {
  Triple<Real> force;
  Dissipation<Real> spent;
};

// Friction on i at the sliding velocity v (in the plane across n, m/s); moves the stretch xi (m) by
// dt.
template <class Real>
[[gnu::always_inline]] inline Friction<Real> slide(const Slider<Real>& s,
                                                   const NextStep<Real>& next,
                                                   const Triple<Real>& n, const Triple<Real>& v,
                                                   Real twist, double dt, Triple<Real>& xi) {
  const Triple<Real> moved = stretched(xi, kept(s.softening), n, v, twist, dt);
  const auto friction = limited(s, moved, v);
  const Real lost = softening_loss(s.k, s.softening, dot(xi, xi));
  xi = friction.stuck * moved;
  const Triple<Real> force = before_end(friction.force, s, next, v, xi, dt);
  const auto spent = dissipation(s, friction.stuck, moved, v, force, dt);
  return {force, {spent.friction + lost, spent.damping}};
}

// Slip of a face and its rotation about the normal times the arm of the face: m, m/s or N.
template <class Real>
struct InFace {
  Triple<Real> slip;
  Real around;
};
template <class Real>
[[gnu::always_inline]] inline InFace<Real> operator+(const InFace<Real>& a, const InFace<Real>& b) {
  return {a.slip + b.slip, a.around + b.around};
}
template <class Real>
[[gnu::always_inline]] inline InFace<Real> operator*(Real s, const InFace<Real>& a) {
  return {s * a.slip, s * a.around};
}
template <class Real>
[[gnu::always_inline]] inline Real dot(const InFace<Real>& a, const InFace<Real>& b) {
  return dot(a.slip, b.slip) + a.around * b.around;
}

// Rotation of a face: arm (root mean square distance of its points from their mean, m; 0: a corner,
// which has no torsion), relative spin of i and j about n (rad/s), and the softening of its spring
// since the step before.
template <class Real>
struct Twisting {
  Real arm, rate, softening;
};

// N, and Nm about n; on i; and what is dissipated.
template <class Real>
struct FaceFriction {
  Triple<Real> force;
  Real moment;
  Dissipation<Real> spent;
};

// Friction of a face and its moment about n, on i; moves the stretch xi (m) and the angle `turn`
// (rad) by dt. The points of the face share their friction between slip and rotation: their springs
// k_s act as a ring, of the stiffness k_s arm^2 (Nm/rad), and force and moment have the common
// limit
//   F^2 + (moment / arm)^2 <= (mu F_n)^2,
// an ellipsoid instead of the exact limit surface (Goyal, Ruina, Papadopoulos 1991,
// doi:10.1016/0043-1648(91)90104-3; Howe, Cutkosky 1996, doi:10.1177/027836499601500603). In
// (force, moment / arm) it is a ball, so that the limit takes energy out as for a force alone. The
// prediction of the next step (`before_end`) leaves torsion out.
template <class Real>
[[gnu::always_inline]] inline FaceFriction<Real> slide(const Slider<Real>& s,
                                                       const NextStep<Real>& next,
                                                       const Triple<Real>& n, const Triple<Real>& v,
                                                       Real twist, const Twisting<Real>& face,
                                                       double dt, Triple<Real>& xi, Real& turn) {
  const Triple<Real> slipped = stretched(xi, kept(s.softening), n, v, twist, dt);
  const Real turned = kept(face.softening) * turn + face.rate * dt;
  const InFace<Real> moved{slipped, face.arm * turned}, rate{v, face.arm * face.rate};
  const auto friction = limited(s, moved, rate);
  const Real lost = softening_loss(s.k, s.softening, dot(xi, xi)) +
                    softening_loss(s.k, face.softening, (face.arm * turn) * (face.arm * turn));
  xi = friction.stuck * slipped;
  turn = select(face.arm > 0, friction.stuck * turned, Real{});
  const Triple<Real> force = before_end(friction.force.slip, s, next, v, xi, dt);
  const auto spent =
      dissipation(s, friction.stuck, moved, rate, InFace<Real>{force, friction.force.around}, dt);
  return {force, face.arm * friction.force.around, {spent.friction + lost, spent.damping}};
}

// The normal force (along -n on i), half of its predicted value in the next step, N (of Hertz
// contacts infinite: they lose their tangential stiffness before they open), the sliding velocity,
// m/s, and what the dashpot dissipates in the step, J.
template <class Real>
struct NormalForce {
  Real now, next;
  Triple<Real> sliding;
  Real damping;
};

// Spring and dashpot act in parallel; their sum is cut, not the dashpot alone: damping may take
// away all of the spring's force but, without attraction, no more.
template <class Real>
[[gnu::always_inline]] inline NormalForce<Real> normal_force(const Coefficients<Real>& c,
                                                             const Touch<Real>& t,
                                                             const NormalSpring<Real>& spring,
                                                             double dt) {
  const Real v_n = dot(t.v, t.n);  // > 0: approaching
  const Real f_n = larger(spring.force + c.c_n * v_n, c.least);
  // The force in the next step if nothing else acts on the two, and half of it, since the force of
  // an opening contact is smaller (`spring_force`).
  const Real slower = v_n - f_n * dt / larger(spring.mass, Real{} + 1e-300);
  const Real half = 0.5 * larger(f_n + c.k_n * dt * slower, Real{});
  return {f_n, select(spring.linear > 0, half, Real{} + 1e300), t.v - v_n * t.n,
          dt * (f_n - spring.force) * v_n};
}

// The slider of friction. No friction from a contact that pulls.
template <class Real>
[[gnu::always_inline]] inline Slider<Real> friction_slider(const Coefficients<Real>& c, Real f_n,
                                                           Real softening) {
  return {c.k_s, c.c_s, c.mu * larger(f_n, Real{}), softening};
}

// Friction on i, the normal force as above, and what both dissipate.
template <class Real>
struct ContactForce {
  Triple<Real> friction;
  Real normal, next;
  Dissipation<Real> spent;
};
template <class Real>
[[gnu::always_inline]] inline ContactForce<Real> contact_force(const Coefficients<Real>& c,
                                                               const Touch<Real>& t,
                                                               const NormalSpring<Real>& spring,
                                                               Real softening, double dt,
                                                               Triple<Real>& xi) {
  const NormalForce<Real> f = normal_force(c, t, spring, dt);
  const NextStep<Real> then{c.mu * f.next, spring.mass};
  const auto friction =
      slide(friction_slider(c, f.now, softening), then, t.n, f.sliding, t.twist, dt, xi);
  return {friction.force, f.now, f.next, friction.spent + Dissipation<Real>{Real{}, f.damping}};
}

// The same of a face, with its moment of torsion about n on i.
template <class Real>
struct FaceForce {
  Triple<Real> friction;
  Real moment, normal, next;
  Dissipation<Real> spent;
};
template <class Real>
[[gnu::always_inline]] inline FaceForce<Real> face_force(const Coefficients<Real>& c,
                                                         const Touch<Real>& t,
                                                         const NormalSpring<Real>& spring,
                                                         Real softening, const Twisting<Real>& face,
                                                         double dt, Triple<Real>& xi, Real& turn) {
  const NormalForce<Real> f = normal_force(c, t, spring, dt);
  const NextStep<Real> then{c.mu * f.next, spring.mass};
  const auto friction = slide(friction_slider(c, f.now, softening), then, t.n, f.sliding, t.twist,
                              face, dt, xi, turn);
  return {friction.force, friction.moment, f.now, f.next,
          friction.spent + Dissipation<Real>{Real{}, f.damping}};
}

// Resistance to rolling; with mu = 0 the slider carries nothing and its stretch stays zero.
template <class Real>
struct Rolling {
  Real mu{};
  Real stiffness = Real{} + 1.0;  // over k_n
  Real zeta{};
};

// What it reads: normal, twist as in Touch, spin of i less that of j, force along the normal now
// and half of that of the next step (ContactForce), k_n (N/m), R: 1/R = 1/R_i + 1/R_j (m), R_i the
// radius of the ball around the piece (a surface is flat: R = R_i).
template <class Real>
struct Rolls {
  Triple<Real> n, spin;
  Real twist, f_n, next, k_n, radius, root_mass;
};

// Nm, and what is dissipated.
template <class Real>
struct RollingMoment {
  Triple<Real> moment;
  Dissipation<Real> spent;
};

// Moment on i against rolling, Nm, by an elastic spring, a dashpot and a slider (Ai, Chen, Rotter,
// Ooi 2011, doi:10.1016/j.powtec.2010.09.030, model C; Iwashita, Oda 1998), in lengths instead of
// angles:
//   d roll/dt = R (w_i - w_j)_t,  f = -k roll - c d roll/dt,  |f| <= mu_r F_n,  moment on i = R f,
// j gets the opposite moment; k = rolling_stiffness k_n, so k_r = k R^2 per angle, and
// c = 2 zeta_r sqrt(k m_eff). The rate of rolling is the tangential part of the relative spin times
// the reduced radius (Luding 2008, doi:10.1007/s10035-008-0099-x): an observer that turns with the
// pair sees the same, whatever the two radii, it is zero when the pair turns as one body, and the
// moment works on nothing else, so that no energy is gained. Critical damping is that of the
// inertia m_eff R^2 (a sphere on a plane has 7/5 of it).
template <class Real>
[[gnu::always_inline]] inline RollingMoment<Real> rolling_moment(const Rolling<Real>& law,
                                                                 const Rolls<Real>& t,
                                                                 Real softening, double dt,
                                                                 Triple<Real>& roll) {
  const Real k = law.stiffness * t.k_n;
  const Real c = 2.0 * law.zeta * root(k) * t.root_mass;
  const Slider<Real> slider{k, c, law.mu * larger(t.f_n, Real{}), softening};
  const NextStep<Real> next{law.mu * t.next, t.root_mass * t.root_mass};
  const Triple<Real> v = t.radius * (t.spin - dot(t.spin, t.n) * t.n);
  const Friction<Real> resistance = slide(slider, next, t.n, v, t.twist, dt, roll);
  return {t.radius * resistance.force, resistance.spent};
}

}  // namespace trackbed::dem
