// Implicit time steps of the family in alpha_scheme.hpp, solved by PETSc.
//
// With m = 1 - alpha_m, f = 1 - alpha_f and the predictors u*, v* (u', v' without a'):
//   (m M + f gamma dt C + f beta dt^2 K) a' = (f F' + alpha_f F) - alpha_m M a
//     - C (f v* + alpha_f v) - K (f u* + alpha_f u),   u' = u* + beta dt^2 a', v' = v* + ...
// The load acts as varying linearly from window to window, the matrix is constant and set up once
// per dt, the first guess extrapolated. Mass is lumped as in the explicit scheme.
//
// Symbols as in explicit.cpp, but beta is the integrator's; dt the window. Unconditionally stable
// as declared in parameters.cpp; second order but for Newmark with gamma > 1/2. One solve per
// window: accuracy, not stability, says how long it may be.
#include <cmath>

#include "alpha_scheme.hpp"
#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Springs below the base are diagonal: they cost the matrix nothing.
void add_springs(const std::vector<Spring>& springs, double factor, int components, Nodal& to) {
  for (const Spring& spring : springs)
    for (int c = 0; c < components; ++c) to[c][spring.node] += factor * spring.stiffness;
}

}  // namespace

// The operator and its multigrid hierarchy are kept while the window keeps its length.
void Ground::Room::prepare_window(double dt, const AlphaScheme& s) {
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
  implicit_.reset();  // the old one's memory first
  implicit_ = std::make_unique<LinearSystem>(mesh, stiffness, spec);
  stiff_ = implicit_->stiffness_diagonal();
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) stiff_[c][n] /= f * s.beta * dt * dt;
  for (Nodal* scratch : {&blend_, &mixed_, &right_})
    if (scratch->of[0].empty()) *scratch = Nodal(components(), nodes);
}

// In place: afterwards u and v hold u* and v*, mixed_ and right_ what the equation takes of
// displacement and velocity, and blend_ what the zones see.
void Ground::Room::predict(double dt, const AlphaScheme& s) {
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

// The right side from what the equation takes of the velocity, both in right_. Returns what
// rounding leaves of it, N: in a ground that has come to rest all its forces cancel, those of each
// zone's displacement too, and a residual below that says nothing. Collective.
double Ground::Room::balance(const AlphaScheme& s, const Nodal& before) {
  // Some fifty roundings of the terms of each freedom, as many as a sum over zones and modes makes.
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
      // Of a ground that yields the return sees the whole stress, that of rest too.
      const double at_rest = plasticity ? std::abs(stiff_[c][n] * state.rest[c][n]) : 0;
      const double size = std::abs(load) + std::abs(stiff_[c][n] * blend_[c][n]) +
                          std::abs(damped) + std::abs(inertia) + at_rest;
      squared += size * size;
    }
  return roundings * std::sqrt(mesh.comm.sum(squared));
}

// The first guess of the acceleration: the parabola through those of the last three windows
// (Lagrange), 0 before the start. It saves 14 to 18 % of the iterations while steps follow the
// motion; a parabola that leads astray, in long steps, is dropped by the solver. Displacement or
// speed carried on say less (docs/decisions/ground_elements.md).
void Ground::Room::extrapolate() {
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

// `before` holds the load of the last window, state.load this one's.
void Ground::Room::implicit_window(double dt, const Nodal& before) {
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
  // Held freedoms keep a = 0: the solver leaves them out.
  if (plasticity) {
    newton(dt, s, rounding_);
  } else {
    iterations += implicit_->solve(right_, state.acceleration, rounding_);
    ++solves;
  }
  ++steps;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      state.displacement[c][n] += s.beta * dt * dt * state.acceleration[c][n];
      state.velocity[c][n] += s.gamma * dt * state.acceleration[c][n];
    }
}

// Solved from the accelerations of the expected load, whose right side is still there: what is left
// to do is the change alone, to the tolerance of the whole.
void Ground::Room::correct_window(double dt, const Nodal& expected_load) {
  require(!plasticity, "a ground that yields takes its step once");
  const AlphaScheme s = alpha_scheme(parameters);
  mixed_ = state.acceleration;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      right_[c][n] += (1 - s.alpha_f) * (state.load[c][n] - expected_load[c][n]);
  iterations += implicit_->solve(right_, state.acceleration, rounding_);
  ++solves;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      const double change = state.acceleration[c][n] - mixed_[c][n];
      state.displacement[c][n] += s.beta * dt * dt * change;
      state.velocity[c][n] += s.gamma * dt * change;
    }
}

Nodal Ground::Room::give_way(double dt) {
  require(!plasticity, "a ground that yields is not linear");
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
