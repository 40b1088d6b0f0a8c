// Central differences, matrix-free, with the state at whole steps (velocity Verlet form):
//   v_h = v + h/2 a,  u += h v_h,  a = M^-1 (F - K (u + beta v_h) - C v),  v = v_h + h/2 a.
// C is diagonal (dashpots, mass-proportional damping) and acts on the new v, which is solved for
// node by node: over a whole step it acts on the mean of both half-step velocities. beta is the
// stiffness-proportional damping. Written for half-step velocities this is the leapfrog scheme.
// Cost per step: one sweep over elements, one over nodes, one message per neighbour.
//
// Symbols: u m, v m/s, a m/s^2, F external load N, M kg, C N s/m, K N/m, beta s, h s. Second order
// in h without beta; stiffness-proportional damping uses the velocity half a step late, which is
// first order in h. The step is that of terms.hpp with the safety factor of the deck.
#include <chrono>
#include <cmath>

#include "fem/ground/impl.hpp"
#include "trackbed/core/whole_steps.hpp"

namespace trackbed::fem {

// Derived coefficients, three per degree of freedom: divisions are done here and not in the sweeps.
void Ground::Impl::prepare_step(double h) {
  if (h == prepared_step_) return;
  prepared_step_ = h;  // windows usually repeat: computed once per run
  if (inverse_mass_.of[0].empty()) {
    inverse_mass_ = damping_rate_ = implicit_factor_ = Nodal(components(), mesh.nodes());
    if (parameters.rayleigh_stiffness > 0) blend_ = Nodal(components(), mesh.nodes());
  }
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      // Zero for fixed degrees of freedom: no branch in the loops of `move`.
      const bool moves = mesh.owned[n] != 0 && (terms.held[n] >> c & 1) == 0;
      inverse_mass_[c][n] = moves ? 1 / terms.mass[n] : 0;
      damping_rate_[c][n] = terms.damping[c][n] * inverse_mass_[c][n];
      implicit_factor_[c][n] = 1 / (1 + 0.5 * h * damping_rate_[c][n]);
    }
}

// One sweep over the nodes. The end of a step and the begin of the next are one sweep, so that the
// arrays pass through the caches once per step: drift is the first half of a step, kick the second,
// kick_and_drift the second and the first of the next step. In kick the new v is on both sides,
//   v = v_h + h/2 (f - rate v),  f = M^-1 (F - internal force),
// hence the factor 1/(1 + h/2 rate).
//
// Ghosts and fixed degrees of freedom have zero inverse mass and do not move.
void Ground::Impl::move(Part part, double h) {
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
        const double driving = inverse[n] * (force[n] - internal[n]);
        const double whole = (v[n] + half * driving) * factor[n];
        v[n] = whole + half * (driving - rate[n] * whole);
        u[n] += h * v[n];
      }
    if (part == Part::kick) {
      double* __restrict__ a = state.acceleration[c];
      for (std::size_t n = 0; n < nodes; ++n) {
        const double driving = inverse[n] * (force[n] - internal[n]);
        v[n] = (v[n] + half * driving) * factor[n];
        a[n] = driving - rate[n] * v[n];
      }
    }
    if (!blends || part == Part::kick) continue;
    double* __restrict__ w = blend_[c];
    for (std::size_t n = 0; n < nodes; ++n) w[n] = u[n] + beta * v[n];
  }
}

// Internal force: solid and springs below the base. The springs are excluded from the
// stiffness-proportional damping, whose damping ratio belongs to the solid.
void Ground::Impl::internal_force(const Nodal& w, const Nodal& u) {
  const auto timing = timers->scope(Phase::ground_elements);
  stiffness.apply(w, state.internal);
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components(); ++c)
      state.internal[c][spring.node] += spring.stiffness * u[c][spring.node];
}

// Stiffness-proportional damping remains elastic: the yield criterion uses the displacement alone,
// whose ghosts are not exchanged otherwise if elements use displacement plus damping.
void Ground::Impl::yield(bool ghosts_current) {
  const auto timing = timers->scope(Phase::ground_plasticity);
  if (!ghosts_current) mesh.exchange(state.displacement);
  plasticity->flow(state.static_displacement, state.displacement);
  plasticity->act_on(state.internal);
}

// Exchanges ghosts, then computes internal forces and those of free field and base at the time
// `at`, s.
void Ground::Impl::compute_forces(double h, double at) {
  // Without stiffness damping the elements use the displacement itself: one array less to move.
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

// As many equal steps as fill the window, each at most the stable one. Without `load` the present
// one is constant.
void Ground::Impl::explicit_window(double dt, const LoadInWindow& load) {
  const std::int64_t n = steps_covering(dt, parameters.safety * critical);
  const double h = dt / static_cast<double>(n);
  prepare_step(h);
  for (std::int64_t s = 0; s < n; ++s) {
    move(s == 0 ? Part::drift : Part::kick_and_drift, h);
    compute_forces(h, time + static_cast<double>(s + 1) * h);
    if (load) set_load(load(static_cast<double>(s + 1) * h));
  }
  move(Part::kick, h);
  steps += n;
}

// The same step in halves: the load at its end may depend on the displacement at its end, so that
// both sides of the coupling are at the same instant (velocity Verlet form of the leapfrog scheme).
void Ground::Impl::begin_step(double h) {
  prepare_step(h);
  move(Part::drift, h);
  compute_forces(h, time + h);
  show_motion();
}

void Ground::Impl::end_step(double h) {
  move(Part::kick, h);
  ++steps;
}

}  // namespace trackbed::fem
