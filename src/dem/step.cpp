// One sub-step: velocity Verlet (Swope et al. 1982, doi:10.1063/1.442716) for the centres, and the
// rotation of rotation.cpp, which is of second order as well. A state between windows is at one
// time level.
#include <algorithm>
#include <cmath>

#include "room.hpp"
#include "rotation.hpp"

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

// Turns an attitude of a plane model about y by `angle`: exact, since its momentum does not turn.
// c, s: cosine and sine of half the angle, as in rotation.cpp.
void rotate_in_plane(Vec4& attitude, double angle) {
  const double x = 0.25 * angle, x2 = x * x;
  const double t = std::abs(angle) < 0.1 ? x * (1 + x2 * (1.0 / 3 + x2 * (2.0 / 15))) : std::tan(x);
  const double over = 1 / (1 + t * t), c = (1 - t * t) * over, s = 2 * t * over;
  const Quat q = quat(attitude);
  const Quat turned(c * q.w() - s * q.y(), c * q.x() - s * q.z(), c * q.y() + s * q.w(),
                    c * q.z() + s * q.x());
  attitude = vec4(turned.normalized());
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
    w = spin_of(state.q[b], l, inertia);
  }
}

// Half a kick: v += dt/2 F/m, L += dt/2 T. Local damping sees the velocity before the kick.
void Particles::Room::kick(double dt) {
  const double half = 0.5 * dt, weight = -parameters.gravity;
  const bool plane = domain.dimension == Dimension::plane;
  const auto& materials = physics.materials;
  const bool any_damped =
      local_damping > 0 ||
      (local_damping < 0 && std::any_of(materials.begin(), materials.end(),
                                        [](const Material& m) { return m.local_damping > 0; }));
  for (std::size_t b = 0; b < state.own; ++b) {
    if (state.held[b] != 0) continue;
    Vec4 &v = state.v[b], &l = state.l[b];
    Vec4 f = state.f[b], t = state.t[b];
    f.z += v.w * weight;
    if (any_damped) {
      const double alpha =
          local_damping >= 0 ? local_damping
                             : materials[static_cast<std::size_t>(state.material[b])].local_damping;
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

// The largest displacement of a surface point since the last rebuild, m.
// |q - q0| = 2 sin(angle/4) or more; 2.1 covers angles up to 1 rad.
double Particles::Room::motion_since_rebuild(std::size_t b) const {
  const Vec4 &x = state.x[b], &from = reference_x[b];
  const double dx = x.x - from.x, dy = x.y - from.y, dz = x.z - from.z;
  const double moved = std::sqrt(dx * dx + dy * dy + dz * dz);
  if (shapes.only_spheres()) return moved;  // the attitude of a sphere is not followed
  const Vec4 &q = state.q[b], &before = reference_q[b];
  const double cx = q.x - before.x, cy = q.y - before.y, cz = q.z - before.z, cw = q.w - before.w;
  return moved + 2.1 * x.w * std::sqrt(cx * cx + cy * cy + cz * cz + cw * cw);
}

// Eight bodies at a time, but for those that keep their spin.
void Particles::Room::drift_in_space(double dt) {
  thread_local std::vector<std::pair<std::size_t, Vec4>> steady;  // and their attitudes
  steady.clear();
  for (std::size_t b = 0; b < state.own; ++b)
    if (state.held[b] != 0) steady.emplace_back(b, state.q[b]);
  largest_motion = drift_and_rotate(state, dt, reference_x, reference_q);
  for (const auto& [b, attitude] : steady) {
    state.q[b] = attitude;
    rotate_steadily(state.q[b], state.l[b], state.inertia[b], dt);
    update_spin(b);
    largest_motion = std::max(largest_motion, motion_since_rebuild(b));
  }
}

// v at half time, then x and attitude for the whole sub-step. Contacts read these velocities of
// half a sub-step: elastic forces do not notice, dampers are half a sub-step late.
void Particles::Room::kick_and_drift(double dt) {
  kick(dt);
  const bool spheres = shapes.only_spheres();
  if (!spheres && domain.dimension == Dimension::space) return drift_in_space(dt);
  double motion = 0;
  for (std::size_t b = 0; b < state.own; ++b) {
    Vec4& x = state.x[b];
    const Vec4 &v = state.v[b], &l = state.l[b], &inertia = state.inertia[b];
    x.x += dt * v.x, x.y += dt * v.y, x.z += dt * v.z;
    if (!spheres) rotate_in_plane(state.q[b], dt * l.y / inertia.y);
    update_spin(b);
    const double moved = motion_since_rebuild(b);
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
