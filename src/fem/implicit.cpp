// What PETSc solves: the static start and Newmark's time steps.
//
// Newmark (1959, doi:10.1061/JMCEA3.0000098) in the acceleration a at the end of the window:
//   u* = u + dt v + dt^2 (1/2 - beta) a,   v* = v + dt (1 - gamma) a,
//   (M + gamma dt C + beta dt^2 K) a' = F - C v* - K u*,   u = u* + beta dt^2 a', v = v* + ...
// The load acts as varying linearly from window to window, the matrix is constant and set up once
// per dt, the last acceleration is the first guess. Mass is lumped as in the explicit scheme.
//
// Symbols as in explicit.cpp, but beta is Newmark's; dt the window. Unconditionally stable for 2
// beta >= gamma >= 1/2; second order for gamma = 1/2, above it waves are damped. One solve per
// window: accuracy, not stability, says how long it may be.
#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Springs below the base as part of a diagonal.
// Springs are diagonal: they cost the matrix nothing.
void add_springs(const std::vector<Spring>& springs, double factor, int components, Nodal& to) {
  for (const Spring& spring : springs)
    for (int c = 0; c < components; ++c) to[c][spring.node] += factor * spring.stiffness;
}

}  // namespace

void Ground::Room::newmark_window(double dt) {
  const double beta = parameters.newmark_beta, gamma = parameters.newmark_gamma;
  const double rayleigh = parameters.rayleigh_stiffness;
  const std::size_t nodes = mesh.nodes();
  // The operator and its multigrid hierarchy are kept while the window keeps its length.
  if (newmark_step_ != dt) {
    newmark_step_ = dt;
    LinearSystem::Spec spec{beta * dt * dt + gamma * dt * rayleigh, Nodal(components(), nodes),
                            terms.held, parameters.tolerance};
    for (int c = 0; c < components(); ++c)
      for (std::size_t n = 0; n < nodes; ++n)
        spec.diagonal[c][n] = terms.mass[n] + gamma * dt * terms.damping[c][n];
    add_springs(terms.springs, beta * dt * dt, components(), spec.diagonal);
    newmark_.reset();  // the old one's memory first
    newmark_ = std::make_unique<LinearSystem>(mesh, stiffness, spec);
    if (blend_.of[0].empty()) blend_ = Nodal(components(), nodes);
  }
  // Predictor, in place: afterwards u and v hold u* and v*.
  Nodal& w = blend_;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      double &u = state.displacement[c][n], &v = state.velocity[c][n];
      const double a = state.acceleration[c][n];
      u += dt * v + dt * dt * (0.5 - beta) * a;
      v += dt * (1 - gamma) * a;
      w[c][n] = u + rayleigh * v;
    }
  mesh.exchange(w);
  internal_force(w);
  Nodal right(components(), nodes);
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      right[c][n] =
          state.load[c][n] - state.internal[c][n] - terms.damping[c][n] * state.velocity[c][n];
  // Held freedoms keep a = 0: the solver leaves them out.
  iterations += newmark_->solve(right, state.acceleration);
  ++solves;
  ++steps;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) {
      state.displacement[c][n] += beta * dt * dt * state.acceleration[c][n];
      state.velocity[c][n] += gamma * dt * state.acceleration[c][n];
    }
}

// Collective. Solves K r = F_0 + weight with the borders of rest. r only enters stresses at rest:
// the motion counts from it and never sees it.
void Ground::Room::settle(std::span<const Vec3> top_force) {
  // The present shape stays the shape shown, as the reference from now on.
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) state.offset[c][n] += state.displacement[c][n];
  for (Nodal* values : {&state.displacement, &state.velocity, &state.acceleration, &state.internal,
                        &state.load, &state.settled})
    values->fill(0);
  // With nothing settled yet the load is the whole force: the new F_0, bit for bit what set_load
  // will take off later, so that the same force leaves exactly nothing.
  set_load(top_force);
  std::swap(state.settled, state.load);

  Nodal right = state.settled;
  // Weight acts on the last component, z, in a plane as in space.
  const int up = components() - 1;
  for (const std::int32_t n : mesh.own)
    right[up][n] -= gravity * terms.mass[static_cast<std::size_t>(n)];
  // Plain K: damping and mass have no part in rest.
  LinearSystem::Spec spec{1.0, Nodal(components(), mesh.nodes()), terms.held_at_rest,
                          parameters.tolerance};
  add_springs(terms.springs, 1.0, components(), spec.diagonal);
  LinearSystem statics(mesh, stiffness, spec);
  // The old static solution is the first guess: settling twice under nearly the same load is cheap.
  iterations += statics.solve(right, state.rest);
  ++solves;
  mesh.exchange(state.rest);
  mesh.exchange(state.offset);
  refresh_surface();
}

}  // namespace trackbed::fem
