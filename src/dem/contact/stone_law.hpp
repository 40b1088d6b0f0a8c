// The law for contacts of pieces with corners, one (Real = double, on surfaces) or eight (Lanes) at
// a time. With the pair's generalised normal (N, T) the overlap grows at the rate M' = (v_i - v_j)
// . N + w_i . T - w_j . (T - D x N), D from the first centre to the second: spring and damper of
// the law act on M and M' and their force does no other work. Friction acts at the mean point of
// contact, in the plane across N; relative rotation about N is resisted as by a ring of the
// contact's spread (zero for a corner). Rolling resistance uses the radii of the balls around the
// two pieces.
#pragma once

#include "dem/contact/stone_blocks.hpp"
#include "dem/law/laws.hpp"
#include "dem/search/pairs.hpp"
#include "dem/shape/features.hpp"

namespace trackbed::dem {

// Input of the law for a contact; positions are relative to the centre of i. On a surface d and the
// spin of j are zero and `drift` is the motion of the surface's features.
template <class Real>
struct StoneTouch {
  Triple<Real> d, N, T, x;      // d: centre of j from that of i
  Triple<Real> vi, vj, wi, wj;  // m/s, rad/s
  Real M, spread;               // m, m^2
  Real root_mass, radius;       // radius: m, of the two curvatures together
  // 1/(kg m2), over the least principal moments; 0: is not rotated
  Real inverse_moment_i, inverse_moment_j;
  Real drift;  // m/s, of features of j along N relative to its motion at x
  Springs<Real> law;
  Rolling<Real> rolling;
  Real rolling_radius;  // m, reduced, of the balls around the two pieces
};

// History of a contact (state.hpp, History).
template <class Real>
struct StoneStretch {
  Triple<Real> xi, roll;
  Real turn, size, ring;
};

template <class Real>
struct StoneForce {
  Triple<Real> force, turn_i, turn_j;  // on i; torque on j of the opposite force
  Triple<Real> friction;
  Real f_n, next, moment, k_n;  // force along -N, now and next, moment of torsion, N/m
  Dissipation<Real> spent;      // J, in the step
};

// Force on i: friction - f_n N, and torque x cross friction - f_n T + moment n; on j the opposite
// force, and the torque about its own centre. f_n is the spring's force on M, N; the normal force
// is f_n |N|, since |N| may exceed 1 (several features) or be less (features with opposite
// normals); it limits friction and torsion. Advances the history by dt.
//
// A unit force on M changes its rate by N . N / m_eff + T . I_i^-1 T + S . I_j^-1 S per second: the
// inverse mass at the ends of the contact, which for a corner far from the centre is several times
// 1/m_eff. `yielding(S, may_end)` gives its last two terms, 1/kg, for contacts that may end.
template <bool rolls, class Real, class Yielding>
[[gnu::always_inline]] inline StoneForce<Real> respond(const StoneTouch<Real>& g,
                                                       const Yielding& yielding, double dt,
                                                       StoneStretch<Real>& h) {
  const Triple<Real> S = g.T - cross(g.d, g.N);  // T about the centre of j
  const Real square = dot(g.N, g.N), length = root(square);
  const Triple<Real> n = (1.0 / larger(length, Real{} + 1e-300)) * g.N;
  const Triple<Real> arm_j = g.x - g.d, u = g.vi - g.vj;
  const Real rate = dot(u, g.N) + dot(g.wi, g.T) - dot(g.wj, S) - g.drift;  // of M
  const Triple<Real> p = u + cross(g.wi, g.x) - cross(g.wj, arm_j);
  // `normal_force` takes the rate of overlap from the velocity along n: here it is that of M.
  const Triple<Real> v = p + (rate - dot(p, n)) * n;
  Springs<Real> law = g.law;
  law.mu = law.mu * length;
  auto c = coefficients<true>(law, g.M, g.root_mass, g.radius);
  // Stiffness and damper act along the motion of a face with |N|^2: divided by |N|, the damper
  // keeps the damping ratio of the law, and so its restitution.
  c.c_n = c.c_n / larger(length, Real{} + 1.0);
  const Real mass = g.root_mass * g.root_mass, tiny = Real{} + 1e-300;
  const Real over = square / larger(mass, tiny);
  const Real most = over + dot(g.T, g.T) * g.inverse_moment_i + dot(S, S) * g.inverse_moment_j;
  constexpr double below = 0.999;  // also after rounding
  const Real least = below / larger(most, tiny);
  const auto exact = [&](auto may_end) {
    return select(may_end, 1.0 / larger(over + yielding(S, may_end), tiny), least);
  };
  // Pairs out of contact have no end: their force is not used.
  const OverlapMotion<Real> motion{select(g.M > 0, g.M, Real{} - 1.0), rate};
  NormalSpring<Real> spring = spring_force<true>(
      law, c, motion, EndMass<Real, decltype(exact)>{least, exact}, g.radius, dt);
  // For the prediction of the next force, whether this contact may end or not: the other lanes must
  // not affect it.
  spring.mass = mass;
  const Real softer = softening(h.size, c.size);
  const Touch<Real> touch{n, v, g.M, 0.5 * dot(g.wi + g.wj, n)};
  const Real ring = c.size * g.spread;
  const Triple<Real> spin = g.wi - g.wj;
  const Twisting<Real> face{root(g.spread), dot(spin, n), softening(h.ring, ring)};
  const auto contact = face_force(c, touch, spring, softer, face, dt, h.xi, h.turn);
  const Real f_n = contact.normal, moment = contact.moment;
  StoneForce<Real> out{contact.friction - f_n * g.N,
                       cross(g.x, contact.friction) - f_n * g.T + moment * n,
                       cross(arm_j, contact.friction) - f_n * S + moment * n,
                       contact.friction,
                       f_n,
                       contact.next,
                       moment,
                       c.k_n,
                       contact.spent};
  if constexpr (rolls) {
    const Rolls<Real> t{
        n,          spin, touch.twist, f_n * length, contact.next * length, c.k_n, g.rolling_radius,
        g.root_mass};
    const auto against = rolling_moment(g.rolling, t, softer, dt, h.roll);
    out.turn_i = out.turn_i + against.moment, out.turn_j = out.turn_j + against.moment;
    out.spent = out.spent + against.spent;
  }
  h.size = c.size, h.ring = ring;
  return out;
}

// Forces of a pair on its particles. The fourth number of the force is what dashpots dissipate in
// the step, that of the torques what friction does, J, or zero without accounts; both particles get
// both.
struct PairForce {
  Vec4 force, turn_i, turn_j;  // N on i, the opposite on j; Nm, turn_j is subtracted on j
};
using PairForces = std::vector<PairForce>;  // by slot (block and lane)

struct PlaceOfPair {
  std::uint32_t entry, slot;  // `StoneBlocks::nowhere`: without a lane now
  std::uint32_t i, j;         // particles
};

// Adds them in the given order.
void add(const std::vector<PlaceOfPair>& order, const PairForces& forces, State& state);

// The law on blocks of pairs, one after the other.
class StoneLaw {
 public:
  StoneLaw(const Scene& scene, double dt, bool rolls, PairForces& forces);
  // Advances the histories of block `number` by dt and stores its forces. Both are zero for a pair
  // that does not overlap.
  void respond(std::size_t number, Block& block, const WrenchLanes& w);
  // Begins to load the data of a block for the law: rows in arbitrary order of addresses.
  void prefetch(const Block& block) const;
  double largest_overlap() const;  // over the smaller radius

 private:
  template <bool rolls, bool accounts>
  void respond_to(std::size_t number, Block& block, const WrenchLanes& w);

  const Scene& scene_;
  double dt_;
  bool rolls_;  // some law resists rolling
  PairForces& forces_;
  LawLanes law_{};
  RollingLanes rolling_{};
  int law_number_ = -1;  // of the law in the lanes
  Lanes worst_ = all(0);
};

}  // namespace trackbed::dem
