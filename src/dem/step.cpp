// One sub-step: velocity Verlet (Swope et al. 1982, doi:10.1063/1.442716) for the centres; the
// rotation of a body about its principal axes in turn (Dullweber, Leimkuhler, McLachlan 1997,
// doi:10.1063/1.474310), which is second order, keeps |q| to rounding and the angular momentum
// exactly. A state between windows is at one time level.
#include <cmath>

#include "room.hpp"

namespace trackbed::dem {

namespace {

// Cundall's local damping: a share of the net force resists the motion.
// F = F - alpha |F| sign(v), for each component (Cundall 1987). It knows no frequency and takes
// nothing from steady motion without net force. It depends on the axes; for rotation the sign is
// that of the angular momentum, not of the spin: the same for spheres, and for stones it needs no
// attitude.
double damped(double force, double velocity, double alpha) {
  return force - alpha * std::copysign(std::abs(force), velocity) * (velocity != 0);
}

// Cosine and sine of half an angle from t = tan(angle/4), so that c^2 + s^2 = 1 to rounding
// whatever t is; t by its series, right to 1e-10 of the angle at the 0.1 rad that a sub-step never
// reaches, and much cheaper than the library's functions.
// c = (1 - t^2)/(1 + t^2), s = 2 t/(1 + t^2).
struct HalfAngle {
  double c, s;
  explicit HalfAngle(double angle) {
    const double x = 0.25 * angle, x2 = x * x;
    const double t =
        std::abs(angle) < 0.1 ? x * (1 + x2 * (1.0 / 3 + x2 * (2.0 / 15))) : std::tan(x);
    const double over = 1 / (1 + t * t);
    c = (1 - t * t) * over, s = 2 * t * over;
  }
};

// Turns the body frame by `angle` about its axis `a` and the angular momentum in it back.
// Rotation about one principal axis alone is free of error: its momentum is constant meanwhile, the
// others turn about it.
[[gnu::always_inline]] inline void turn(Quat& q, Vec3& body_momentum, int a, double angle) {
  const auto [c, s] = HalfAngle(angle);
  const int b = (a + 1) % 3, d = (a + 2) % 3;
  auto& v = q.coeffs();  // x y z w; the product with (c, s about a), zeros left out
  const double qa = v[a], qb = v[b], qd = v[d], qw = v[3];
  v[3] = c * qw - s * qa, v[a] = c * qa + s * qw;
  v[b] = c * qb + s * qd, v[d] = c * qd - s * qb;
  const double cos = c * c - s * s, sin = 2 * s * c;
  const double lb = body_momentum[b], ld = body_momentum[d];
  body_momentum[b] = cos * lb + sin * ld;
  body_momentum[d] = cos * ld - sin * lb;
}

// Free rotation for dt: the kinetic energy is split in its three parts L_a^2 / (2 I_a), each moved
// exactly, in the order x y z y x, which is symmetric and so of second order. Momentum in space
// axes is not touched. Rejected: Runge-Kutta on q and w, which drifts in |q| and in energy.
void rotate_in_space(Vec4& attitude, const Vec4& momentum, const Vec4& inertia, double dt) {
  Quat q = quat(attitude);
  Vec3 body = q.conjugate() * momentum.vec3();
  turn(q, body, 0, 0.5 * dt * body[0] / inertia.x);
  turn(q, body, 1, 0.5 * dt * body[1] / inertia.y);
  turn(q, body, 2, dt * body[2] / inertia.z);
  turn(q, body, 1, 0.5 * dt * body[1] / inertia.y);
  turn(q, body, 0, 0.5 * dt * body[0] / inertia.x);
  // Takes away rounding only: every part keeps |q|.
  q.normalize();
  attitude = vec4(q);
}

// A body that keeps its spin turns about it, and its angular momentum follows the attitude. The
// spin comes from the momentum, as everywhere: so it is the same before and after a change of
// ranks.
void rotate_steadily(Vec4& attitude, Vec4& momentum, const Vec4& inertia, double dt) {
  const Vec3 moments = inertia.vec3();
  Quat q = quat(attitude);
  const Vec3 body = q.conjugate() * momentum.vec3();
  const Vec3 spin = q * Vec3(body.cwiseQuotient(moments));
  const double rate = spin.norm();
  if (!(rate > 0)) return;
  q = (Quat(Eigen::AngleAxisd(dt * rate, spin / rate)) * q).normalized();
  attitude = vec4(q);
  momentum.set(q * Vec3((q.conjugate() * spin).cwiseProduct(moments)));
}

}  // namespace

// w = I^-1 L in space axes. Ghosts get the bits of their owner afterwards: L is not sent.
void Particles::Room::update_spin(std::size_t b) {
  Vec4& w = state.w[b];
  const Vec4 &l = state.l[b], &inertia = state.inertia[b];
  if (shapes.only_spheres()) {
    const double over = 1.0 / inertia.y;
    w.x = over * l.x, w.y = over * l.y, w.z = over * l.z;
  } else if (domain.dimension == Dimension::plane) {
    w = {0, l.y / inertia.y, 0, 0};
  } else {
    const Quat q = quat(state.q[b]);
    const Vec3 body = q.conjugate() * l.vec3();
    w.set(q * Vec3(body.x() / inertia.x, body.y() / inertia.y, body.z() / inertia.z));
  }
}

// Half a kick: v += dt/2 F/m, L += dt/2 T. Local damping sees the velocity before the kick.
void Particles::Room::kick(double dt) {
  const double half = 0.5 * dt, weight = -parameters.gravity;
  const bool plane = domain.dimension == Dimension::plane;
  for (std::size_t b = 0; b < state.own; ++b) {
    if (state.held[b] != 0) continue;
    Vec4 &v = state.v[b], &l = state.l[b];
    Vec4 f = state.f[b], t = state.t[b];
    f.z += v.w * weight;
    const double alpha =
        local_damping >= 0
            ? local_damping
            : physics.materials[static_cast<std::size_t>(state.material[b])].local_damping;
    if (alpha > 0) {
      f.x = damped(f.x, v.x, alpha), f.y = damped(f.y, v.y, alpha), f.z = damped(f.z, v.z, alpha);
      t.x = damped(t.x, l.x, alpha), t.y = damped(t.y, l.y, alpha), t.z = damped(t.z, l.z, alpha);
    }
    // Frozen freedoms of a plane model: what pulls there is carried by the plane.
    if (plane) f.y = t.x = t.z = 0;
    const double over_mass = half / v.w;
    v.x += over_mass * f.x, v.y += over_mass * f.y, v.z += over_mass * f.z;
    l.x += half * t.x, l.y += half * t.y, l.z += half * t.z;
  }
}

// v at half time, then x and attitude for the whole sub-step. Contacts read these velocities of
// half a sub-step: elastic forces do not notice, dampers are half a sub-step late.
void Particles::Room::kick_and_drift(double dt) {
  kick(dt);
  const bool spheres = shapes.only_spheres(), plane = domain.dimension == Dimension::plane;
  double motion = 0;
  for (std::size_t b = 0; b < state.own; ++b) {
    Vec4 &x = state.x[b], &q = state.q[b];
    const Vec4 &v = state.v[b], &l = state.l[b], &inertia = state.inertia[b];
    x.x += dt * v.x, x.y += dt * v.y, x.z += dt * v.z;
    const Vec4& from = reference_x[b];
    const double dx = x.x - from.x, dy = x.y - from.y, dz = x.z - from.z;
    double moved = std::sqrt(dx * dx + dy * dy + dz * dz);
    if (!spheres) {  // the attitude of a sphere is not followed
      if (plane) {
        Vec3 momentum(0, l.y, 0);
        Quat attitude = quat(q);
        turn(attitude, momentum, 1, dt * l.y / inertia.y);
        q = vec4(attitude.normalized());
      } else if (state.held[b] != 0) {
        rotate_steadily(q, state.l[b], inertia, dt);
      } else {
        rotate_in_space(q, l, inertia, dt);
      }
      const Vec4& before = reference_q[b];
      const double cx = q.x - before.x, cy = q.y - before.y, cz = q.z - before.z,
                   cw = q.w - before.w;
      // |q - q0| = 2 sin(angle/4) or more; 2.1 covers angles up to 1 rad.
      moved += 2.1 * x.w * std::sqrt(cx * cx + cy * cy + cz * cz + cw * cw);
    }
    update_spin(b);
    motion = moved > motion ? moved : motion;
  }
  largest_motion = motion;
}

// Nodes that are not known here are not a number and do not count.
double Particles::Room::surface_motion_since_rebuild() const {
  double motion = 0;
  for (std::size_t k = 0; k < surfaces.size(); ++k)
    for (std::size_t n = 0; n < surfaces[k]->nodes(); ++n) {
      const double moved =
          (node_at(*surfaces[k], static_cast<std::int32_t>(n), 1) - surface_reference[k][n]).norm();
      if (moved > motion) motion = moved;
    }
  return motion;
}

bool Particles::Room::lists_are_old() const {
  // Two particles may close twice the largest way, a particle and a surface the sum of both ways;
  // and what they have grown comes on top.
  const double closer = std::max(2 * largest_motion, largest_motion + surface_motion) +
                        2 * bound * (state.grown - reference_grown);
  // Written so that a position that is not a number asks for a rebuild, which reports it.
  const bool old = !(closer <= skin) || crossed_a_border();
  return comm.max(static_cast<std::int64_t>(old)) > 0;
}

// At its end positions, velocities and forces are of one time. One exchange: ghosts, or all of a
// rebuild. The question whether lists are old is a reduction over all ranks, the other message of a
// sub-step.
void Particles::Room::substep(const SubStep& step) {
  kick_and_drift(step.dt);
  if (lists_are_old())
    rebuild();
  else
    update_ghosts();
  feel_pairs(step.dt);
  feel_surfaces(step);
  kick(step.dt);
  ++steps;
}

}  // namespace trackbed::dem
