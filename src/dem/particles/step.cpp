// One sub-step: velocity Verlet (Swope et al. 1982, doi:10.1063/1.442716) for the centres, and the
// rotation of rotation.cpp, which is of second order as well. Between windows all quantities are at
// one time level.
#include <algorithm>
#include <cmath>

#include "dem/particles/impl.hpp"
#include "dem/state/kick.hpp"
#include "dem/state/rotation.hpp"

namespace trackbed::dem {

namespace {

// A body of prescribed spin rotates about it, and its angular momentum follows the attitude. The
// spin is computed from the momentum, as everywhere, so that it does not depend on a change of
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

// A ball whose attitude is followed. Its spin is constant in a sub-step.
void rotate_ball(Vec4& attitude, const Vec4& w, double dt) {
  const Vec3 spin = w.vec3();
  const double rate = spin.norm();
  if (!(rate > 0)) return;
  attitude = vec4((Quat(Eigen::AngleAxisd(dt * rate, spin / rate)) * quat(attitude)).normalized());
}

// From the angular momentum, whose fourth number is one over the moment of inertia.
[[gnu::always_inline]] inline Four spin_of_sphere(Four l) { return l * (l[3] * Four{1, 1, 1, 0}); }

// Of the first three numbers.
[[gnu::always_inline]] inline double square(Four a) {
  return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}
}  // namespace

// w = I^-1 L in space axes.
Four Particles::Impl::spin_from(std::size_t b, Four l) const {
  if (shapes.only_spheres()) return spin_of_sphere(l);
  if (domain.dimension == Dimension::plane) return Four{0, l[1] / state.inertia[b].y, 0, 0};
  Vec4 momentum;
  put(momentum, l);
  return four(spin_of(state.q[b], momentum, state.inertia[b]));
}

// Ghosts receive the value of their owner afterwards: L is not sent.
void Particles::Impl::update_spin(std::size_t b) {
  put(state.w[b], spin_from(b, four(state.l[b])));
}

double Particles::Impl::local_damping_of(std::size_t b) const {
  if (local_damping >= 0) return local_damping;
  return physics.materials[static_cast<std::size_t>(state.material[b])].local_damping;
}

// The energy that the impulse of local damping takes out in each half kick: its product with the
// mean of the velocities before and after, and the same of rotation.
void Particles::Impl::account_for_local_damping(const Kick& kick, int halves) {
  if (!parameters.energy_balance) return;
  const auto product = [](Four a, Four b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  for (std::size_t b = 0; b < state.own; ++b) {
    const double alpha = local_damping_of(b);
    if (state.held[b] != 0 || !(alpha > 0)) continue;
    Four v = four(state.v[b]), l = four(state.l[b]);
    for (int k = 0; k < halves; ++k) {
      Four free_v = v, free_l = l;
      const Four v_before = v, l_before = l;
      kick(free_v, free_l, four(state.f[b]), four(state.t[b]), 1, 0);
      kick(v, l, four(state.f[b]), four(state.t[b]), 1, alpha);
      state.account[b].z += 0.5 * mass(b) * product(free_v - v, v_before + v) +
                            0.5 * product(free_l - l, spin_from(b, l_before) + spin_from(b, l));
    }
  }
}

// After all forces of a sub-step are known. Each particle of a pair gets half.
void Particles::Impl::update_accounts() {
  if (!parameters.energy_balance) return;
  for (std::size_t b = 0; b < state.own; ++b) {
    Vec4& account = state.account[b];
    account.x += 0.5 * state.t[b].w, account.y += 0.5 * state.f[b].w;
  }
}

void Particles::Impl::kick(double dt, int halves) {
  const Kick kick(dt, parameters.gravity, domain.dimension);
  account_for_local_damping(kick, halves);
  for (std::size_t b = 0; b < state.own; ++b) {
    if (state.held[b] != 0) continue;
    Four v = four(state.v[b]), l = four(state.l[b]);
    kick(v, l, four(state.f[b]), four(state.t[b]), halves, local_damping_of(b));
    put(state.v[b], v), put(state.l[b], l);
  }
}

// The largest displacement of a surface point since the last rebuild, m.
// |q - q0| = 2 sin(angle/4) or more; 2.1 covers angles up to 1 rad.
double Particles::Impl::motion_since_rebuild(std::size_t b) const {
  const Vec4 &x = state.x[b], &from = reference_x[b];
  const double dx = x.x - from.x, dy = x.y - from.y, dz = x.z - from.z;
  const double moved = std::sqrt(dx * dx + dy * dy + dz * dz);
  const Vec4 &q = state.q[b], &before = reference_q[b];
  const double cx = q.x - before.x, cy = q.y - before.y, cz = q.z - before.z, cw = q.w - before.w;
  return moved + 2.1 * x.w * std::sqrt(cx * cx + cy * cy + cz * cz + cw * cw);
}

// Eight bodies at a time. In space, bodies with prescribed spin are rotated apart from them.
void Particles::Impl::drift_and_rotate(double dt) {
  thread_local std::vector<std::pair<std::size_t, Vec4>> steady;  // and their attitudes
  steady.clear();
  const bool space = domain.dimension == Dimension::space;
  for (std::size_t b = 0; b < state.own && space; ++b)
    if (state.held[b] != 0) steady.emplace_back(b, state.q[b]);
  const LargestMotion largest =
      dem::drift_and_rotate(state, domain.dimension, dt,
                            {reference_x, reference_q, near_valid ? near.slow.data() : nullptr});
  largest_motion = largest.displacement, largest_speed = largest.slow_speed;
  for (const auto& [b, attitude] : steady) {
    state.q[b] = attitude;
    rotate_steadily(state.q[b], state.l[b], state.inertia[b], dt);
    update_spin(b);
    largest_motion = not_below(motion_since_rebuild(b), largest_motion);
    if (near_valid) largest_speed = not_below(near.slow[b] * speed(b), largest_speed);
  }
}

// One pass over the rows of spheres and disks, whose attitudes are not updated. The cost is memory
// traffic: 210 bytes read and 190 written for each. Forces and torques are set to zero after use,
// for the next evaluation of contacts.
void Particles::Impl::kick_and_drift_spheres(double dt, int halves) {
  const Kick kick(dt, parameters.gravity, domain.dimension);
  account_for_local_damping(kick, halves);
  const Four step = {dt, dt, dt, 0};
  double motion = 0, speed = 0;  // squares
  for (std::size_t b = 0; b < state.own; ++b) {
    Four v = four(state.v[b]), l = four(state.l[b]);
    if (state.held[b] == 0) {
      kick(v, l, four(state.f[b]), four(state.t[b]), halves, local_damping_of(b));
      put(state.v[b], v), put(state.l[b], l);
    }
    put(state.f[b], Four{}), put(state.t[b], Four{});
    const Four x = four(state.x[b]) + step * v;
    put(state.x[b], x);
    put(state.w[b], spin_of_sphere(l));
    motion = not_below(square(x - four(reference_x[b])), motion);
    if (near_valid) speed = not_below(near.slow[b] * square(v), speed);
  }
  largest_motion = std::sqrt(motion), largest_speed = std::sqrt(speed);
  if (!bonding.any) return;
  for (std::size_t b = 0; b < state.own; ++b) rotate_ball(state.q[b], state.w[b], dt);
}

// v at half time, then x and attitude for the whole sub-step. Contacts use these velocities of half
// a sub-step earlier: elastic forces are not affected, dampers are half a sub-step late.
void Particles::Impl::kick_and_drift(double dt, int halves) {
  if (shapes.only_spheres()) return kick_and_drift_spheres(dt, halves);
  kick(dt, halves);
  drift_and_rotate(dt);
}

// Nodes that are unknown on this rank are not a number and do not count.
double Particles::Impl::surface_motion_since_rebuild() const {
  double motion = 0;
  for (std::size_t k = 0; k < surfaces.size(); ++k)
    for (std::size_t n = 0; n < surfaces[k]->nodes(); ++n) {
      const double moved =
          (node_at(*surfaces[k], static_cast<std::int32_t>(n), 1) - surface_reference[k][n]).norm();
      if (moved > motion) motion = moved;
    }
  return motion;
}

bool Particles::Impl::lists_are_old() const {
  // Two particles may approach by twice the largest displacement, a particle and a surface by the
  // sum of both; growth is added, that of fragments at the begin of the next window as well.
  const double closer = std::max(2 * largest_motion, largest_motion + surface_motion) +
                        2 * bound * (state.grown - reference_grown) +
                        2 * (breaking.grown_since_rebuild + breaking.next_growth);
  // Written so that a position that is not a number causes a rebuild, which reports it.
  const bool old = !(closer <= skin) || crossed_a_border();
  const auto timing = timers->scope(Phase::waiting);
  return comm.max(static_cast<std::int64_t>(old)) > 0;
}

// One exchange: ghosts, or all data of a rebuild. Whether lists are outdated is decided by a
// reduction over all ranks, the other communication of a sub-step. A sub-step begins with the half
// kick that closes the previous one, so that velocities are at half time at its end; `advance`
// closes the window.
void Particles::Impl::substep(const SubStep& step) {
  {
    const auto timing = scope(Phase::integration);
    kick_and_drift(step.dt, step.number == 1 ? 1 : 2);
  }
  if (lists_are_old())
    rebuild();
  else
    update_ghosts();
  {
    const auto timing = scope(Phase::pair_forces);
    compute_pair_forces(step.dt);
  }
  {
    const auto timing = scope(Phase::surface_forces);
    compute_surface_forces(step);
    add_friction_work();
  }
  if (bonding.any) {
    const auto timing = scope(Phase::pair_forces);
    compute_bond_forces(step);
  }
  {
    const auto timing = scope(Phase::integration);
    update_accounts();
  }
  ++steps;
}

}  // namespace trackbed::dem
