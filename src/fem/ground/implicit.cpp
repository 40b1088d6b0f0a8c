// Implicit time steps of the family in alpha_scheme.hpp, solved by PETSc.
//
// With m = 1 - alpha_m, f = 1 - alpha_f and the predictors u*, v* (u', v' without a'):
//   (m M + f gamma dt C + f beta dt^2 K) a' = (f F' + alpha_f F) - alpha_m M a
//     - C (f v* + alpha_f v) - K (f u* + alpha_f u),   u' = u* + beta dt^2 a', v' = v* + ...
// The load varies linearly from window to window, the matrix is constant and set up once per dt,
// the first guess is extrapolated. Mass is lumped as in the explicit scheme.
//
// Symbols as in explicit.cpp, but beta is that of the integrator; dt the window. Unconditionally
// stable as declared in parameters.cpp; second order except for Newmark with gamma > 1/2. One solve
// per window: its length is limited by accuracy, not by stability.
#include <cmath>

#include "fem/ground/impl.hpp"
#include "fem/time/alpha_scheme.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Springs below the base are diagonal: no cost in the matrix.
void add_springs(const std::vector<Spring>& springs, double factor, int components, Nodal& to) {
  for (const Spring& spring : springs)
    for (int c = 0; c < components; ++c) to[c][spring.node] += factor * spring.stiffness;
}

}  // namespace

// The operator and its multigrid hierarchy are kept as long as the window has the same length.
void Ground::Impl::prepare_window(double dt, const AlphaScheme& s) {
  if (implicit_step_ == dt) return;
  implicit_step_ = dt;
  const double m = 1 - s.alpha_m, f = 1 - s.alpha_f;
  const std::size_t nodes = mesh.nodes();
  LinearSystem::Spec spec{{}, Nodal(components(), nodes), terms.held, parameters.tolerance};
  spec.common = f * (s.beta * dt * dt + s.gamma * dt * parameters.rayleigh_stiffness);
  spec.use = LinearSystem::Use::in_every_step;
  spec.damping = f * s.gamma * dt;
  for (const Elastic& solid : mesh.solids.solid)
    spec.stiffness_factor.push_back(f *
                                    (s.beta * dt * dt + s.gamma * dt * solid.rayleigh_stiffness));
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < nodes; ++n)
      spec.diagonal[c][n] = m * terms.mass[n] + f * s.gamma * dt * terms.damping[c][n];
  add_springs(terms.springs, f * s.beta * dt * dt, components(), spec.diagonal);
  implicit_.reset();  // frees the memory of the old one first
  implicit_ = std::make_unique<LinearSystem>(mesh, stiffness, spec);
  stiff_ = implicit_->stiffness_diagonal();
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) stiff_[c][n] /= f * s.beta * dt * dt;
  for (Nodal* scratch : {&blend_, &mixed_, &right_})
    if (scratch->of[0].empty()) *scratch = Nodal(components(), nodes);
}

// In place: afterwards u and v hold u* and v*, mixed_ and right_ the mixed displacement and
// velocity of the equation, and blend_ the displacement on which element stiffness acts.
void Ground::Impl::predict(double dt, const AlphaScheme& s) {
  const double f = 1 - s.alpha_f, rayleigh = parameters.rayleigh_stiffness;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      double &u = state.displacement[c][n], &v = state.velocity[c][n];
      const double a = state.acceleration[c][n], u_before = u, v_before = v;
      u += dt * v + dt * dt * (0.5 - s.beta) * a;
      v += dt * (1 - s.gamma) * a;
      mixed_[c][n] = f * u + s.alpha_f * u_before;
      right_[c][n] = f * v + s.alpha_f * v_before;
      blend_[c][n] = mixed_[c][n] + rayleigh * right_[c][n];
    }
}

// The right-hand side, in right_, which contains the mixed velocity on entry. Returns its rounding
// error, N: in a ground at rest all forces cancel, including those of each element's displacement,
// and a residual below this value is meaningless. Collective.
double Ground::Impl::balance(const AlphaScheme& s, const Nodal& before) {
  // Some fifty rounding errors of the terms of each degree of freedom, as many as in a sum over
  // elements and modes.
  constexpr double roundings = 1e-14;
  double squared = 0;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t own : mesh.own) {
      const auto n = static_cast<std::size_t>(own);
      const double load = (1 - s.alpha_f) * state.load[c][n] + s.alpha_f * before[c][n];
      const double damped = terms.damping[c][n] * right_[c][n];
      const double inertia = s.alpha_m * terms.mass[n] * state.acceleration[c][n];
      right_[c][n] = load - state.internal[c][n] - damped - inertia;
      if ((terms.held[n] >> c & 1) != 0) continue;
      // In a yielding ground the return mapping uses the whole stress, including the static one.
      const double at_rest =
          plasticity ? std::abs(stiff_[c][n] * state.static_displacement[c][n]) : 0;
      const double size = std::abs(load) + std::abs(stiff_[c][n] * blend_[c][n]) +
                          std::abs(damped) + std::abs(inertia) + at_rest;
      squared += size * size;
    }
  return roundings * std::sqrt(mesh.comm.sum(squared));
}

// The first guess of the acceleration: the parabola through those of the last three windows
// (Lagrange), 0 before the start. It saves 14 to 18 % of the iterations while steps resolve the
// motion; if it is poor, in long steps, the solver drops it. Extrapolated displacement or velocity
// saves less (docs/decisions/ground_elements.md).
void Ground::Impl::extrapolate() {
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      double &a = state.acceleration[c][n], &one = state.one_before[c][n],
             &two = state.two_before[c][n];
      const double guess = 3 * (a - one) + two;
      two = one;
      one = a;
      a = guess;
    }
}

// `before` holds the load of the last window, state.load that of this one.
void Ground::Impl::implicit_window(double dt, const Nodal& before) {
  const AlphaScheme s = alpha_scheme(parameters);
  prepare_window(dt, s);
  predict(dt, s);
  mesh.exchange(blend_);
  internal_force(blend_, mixed_);
  if (stiffness.damps()) {
    mesh.exchange(right_);
    stiffness.add_damping(right_, state.internal);
  }
  if (free_field) {
    free_field->implicit_step(dt, s, time + dt);
    free_field->act_on(state.internal);
  }
  rounding_ = balance(s, before);
  extrapolate();
  // Fixed degrees of freedom keep a = 0: the solver excludes them.
  if (plasticity) {
    newton(dt, s, rounding_);
  } else {
    solve(right_, rounding_);
    ++solves;
  }
  ++steps;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      state.displacement[c][n] += s.beta * dt * dt * state.acceleration[c][n];
      state.velocity[c][n] += s.gamma * dt * state.acceleration[c][n];
    }
}

void Ground::Impl::solve(const Nodal& right, double rounding) {
  const auto timing = timers->scope(Phase::ground_solve);
  iterations += implicit_->solve(right, state.acceleration, rounding);
}

// Solved with the accelerations of the expected load as first guess, whose right-hand side is still
// available: only the change remains to be solved, to the tolerance of the whole.
void Ground::Impl::correct_window(double dt, const Nodal& expected_load) {
  require(!plasticity, "a yielding ground solves each step once");
  const AlphaScheme s = alpha_scheme(parameters);
  mixed_ = state.acceleration;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      right_[c][n] += (1 - s.alpha_f) * (state.load[c][n] - expected_load[c][n]);
  solve(right_, rounding_);
  ++solves;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      const double change = state.acceleration[c][n] - mixed_[c][n];
      state.displacement[c][n] += s.beta * dt * dt * change;
      state.velocity[c][n] += s.gamma * dt * change;
    }
}

Nodal Ground::Impl::deflection(double dt) {
  require(!plasticity, "the deflection of a ground is computed only if no layer yields");
  const AlphaScheme s = alpha_scheme(parameters);
  prepare_window(dt, s);
  Nodal moved(components(), mesh.nodes());
  right_.fill(0);
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : top_nodes)
      right_[c][n] = (1 - s.alpha_f) * (state.load[c][n] + state.settled[c][n]);
  implicit_->solve(right_, moved);
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) moved[c][n] *= s.beta * dt * dt;
  return moved;
}

}  // namespace trackbed::fem
