// Central differences, matrix-free, with the state at whole steps (velocity Verlet form):
//   v_h = v + h/2 a,  u += h v_h,  a = M^-1 (F - K (u + beta v_h) - C v),  v = v_h + h/2 a.
// C is diagonal (dashpots, mass-proportional damping) and acts on the new v, which is solved for
// node by node: over a whole step it sees the mean of both half-step velocities. beta is the
// stiffness-proportional damping. Written for half-step velocities it is the leapfrog scheme.
// Cost per step: one sweep over zones, one over nodes, one message per neighbour.
//
// Symbols: u m, v m/s, a m/s^2, F load from outside N, M kg, C N s/m, K N/m, beta s, h s. Second
// order in h without beta; damping by stiffness takes the velocity half a step late, which is of
// first order in h. The step is that of terms.hpp with the deck's safety.
#include <chrono>
#include <cmath>

#include "room.hpp"

namespace trackbed::fem {

// Derived numbers, three per freedom: divisions are done here and not in the sweeps.
void Ground::Room::prepare_step(double h) {
  if (h == prepared_step_) return;
  prepared_step_ = h;  // windows usually repeat: computed once per run
  if (inverse_mass_.of[0].empty()) {
    inverse_mass_ = damping_rate_ = implicit_factor_ = Nodal(components(), mesh.nodes());
    if (parameters.rayleigh_stiffness > 0) blend_ = Nodal(components(), mesh.nodes());
  }
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      // Zero for what must not move: no branch in the loops of `move`.
      const bool moves = mesh.owned[n] != 0 && (terms.held[n] >> c & 1) == 0;
      inverse_mass_[c][n] = moves ? 1 / terms.mass[n] : 0;
      damping_rate_[c][n] = terms.damping[c][n] * inverse_mass_[c][n];
      implicit_factor_[c][n] = 1 / (1 + 0.5 * h * damping_rate_[c][n]);
    }
}

// One sweep over the nodes. The end of a step and the begin of the next are one sweep, so that the
// arrays pass through the caches once per step: drift is the first half of a step, kick the second,
// kick_and_drift the second and the next one's first. In kick the new v stands on both sides,
//   v = v_h + h/2 (push - rate v),
// hence the factor 1/(1 + h/2 rate).
//
// Ghosts and held freedoms have no inverse mass and stay where they are.
void Ground::Room::move(Part part, double h) {
  const bool blends = parameters.rayleigh_stiffness > 0;
  const double half = 0.5 * h, beta = parameters.rayleigh_stiffness;
  for (int c = 0; c < components(); ++c) {
    double* __restrict__ u = state.displacement[c];
    double* __restrict__ v = state.velocity[c];
    const double* __restrict__ force = state.load[c];
    const double* __restrict__ internal = state.internal[c];
    const double* __restrict__ inverse = inverse_mass_[c];
    const double* __restrict__ rate = damping_rate_[c];
    const double* __restrict__ factor = implicit_factor_[c];
    const std::size_t nodes = mesh.nodes();
    if (part == Part::drift)
      for (std::size_t n = 0; n < nodes; ++n) {
        v[n] += half * (inverse[n] * (force[n] - internal[n]) - rate[n] * v[n]);
        u[n] += h * v[n];
      }
    if (part == Part::kick_and_drift)
      for (std::size_t n = 0; n < nodes; ++n) {
        const double push = inverse[n] * (force[n] - internal[n]);
        const double whole = (v[n] + half * push) * factor[n];
        v[n] = whole + half * (push - rate[n] * whole);
        u[n] += h * v[n];
      }
    if (part == Part::kick) {
      double* __restrict__ a = state.acceleration[c];
      for (std::size_t n = 0; n < nodes; ++n) {
        const double push = inverse[n] * (force[n] - internal[n]);
        v[n] = (v[n] + half * push) * factor[n];
        a[n] = push - rate[n] * v[n];
      }
    }
    if (!blends || part == Part::kick) continue;
    double* __restrict__ w = blend_[c];
    for (std::size_t n = 0; n < nodes; ++n) w[n] = u[n] + beta * v[n];
  }
}

// What the deformed ground pulls back with: solid and springs below the base. The springs are left
// out of the stiffness-proportional damping, whose ratio belongs to the solid.
void Ground::Room::internal_force(const Nodal& w, const Nodal& u) {
  stiffness.apply(w, state.internal);
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components(); ++c)
      state.internal[c][spring.node] += spring.stiffness * u[c][spring.node];
}

// Damping by stiffness stays elastic: zones that yield are tested with the displacement alone,
// whose ghosts are not sent otherwise when zones see a blend.
void Ground::Room::yield(bool ghosts_current) {
  if (!ghosts_current) mesh.exchange(state.displacement);
  plasticity->flow(state.rest, state.displacement);
  plasticity->act_on(state.internal);
}

// Tell the ghosts, pull back, and what comes from beside and below at the time `at`, s.
void Ground::Room::pull_back(double h, double at) {
  // Without stiffness damping the zones see the displacement itself: one array less to move.
  Nodal& w = parameters.rayleigh_stiffness > 0 ? blend_ : state.displacement;
  mesh.exchange(w);
  internal_force(w, state.displacement);
  if (plasticity) yield(&w == &state.displacement);
  if (stiffness.damps()) {
    mesh.exchange(state.velocity);
    stiffness.add_damping(state.velocity, state.internal);
  }
  if (!free_field) return;
  free_field->explicit_step(h, at);
  free_field->act_on(state.internal);
}

// As many equal steps as fill the window, each at most the stable one. The load is constant in the
// window: it is the mean of the last one.
void Ground::Room::explicit_window(double dt) {
  // A step that is larger than allowed by rounding alone must not be halved.
  constexpr double rounding = 1e-9;
  const double allowed = parameters.safety * critical;
  const auto count = static_cast<std::int64_t>(std::ceil(dt / allowed - rounding));
  const std::int64_t n = count > 0 ? count : 1;
  const double h = dt / static_cast<double>(n);
  prepare_step(h);
  for (std::int64_t s = 0; s < n; ++s) {
    move(s == 0 ? Part::drift : Part::kick_and_drift, h);
    pull_back(h, time + static_cast<double>(s + 1) * h);
  }
  move(Part::kick, h);
  steps += n;
}

// The same step in halves: the load at its end may be that of where it ended, so that whoever gives
// it feels the ground at the same instant (velocity Verlet form of the leapfrog scheme).
void Ground::Room::begin_step(double h) {
  prepare_step(h);
  move(Part::drift, h);
  pull_back(h, time + h);
  show_motion();
}

void Ground::Room::end_step(double h) {
  move(Part::kick, h);
  ++steps;
}

}  // namespace trackbed::fem
