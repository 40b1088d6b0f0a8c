// Static equilibrium under weight and settled load, elastic or yielding.
//
// Yielding solids: the initial stress method (Zienkiewicz, Valliappan, King 1969,
// doi:10.1002/nme.1620010107). Elastic solves under the load and the forces of the present plastic
// strain alternate with a return mapping of all stresses. It keeps the elastic matrix and converges
// slowly near collapse. Rejected: Newton's method with the consistent tangent (unsymmetric without
// dilation, and not bitwise identical on any number of ranks).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/ground/impl.hpp"
#include "fem/solver/static_solver.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Out-of-balance force over all forces. The remainder becomes plastic strain in the first steps.
constexpr double enough = 1e-5;

std::string divergence(int iterations, std::int64_t patience, double residual) {
  return fmt::format(
      "static solve of the ground did not converge: the relative out-of-balance force is {:.2g} "
      "(required: {:g}) after {} iterations and has not halved within the last {}; check loads, "
      "cohesion, friction_angle and tensile_strength; if the ground is stable but near collapse, "
      "increase ground.static_iterations",
      residual, enough, iterations, patience);
}

// Near collapse the increments of successive iterations have the same direction and decrease
// geometrically; from time to time the remainder of the series is added at once (Aitken 1926,
// doi:10.1017/S0370164600022070). A slope with a reserve of 3 % then takes 1000 iterations instead
// of 5600. Plastic strain that overshoots by it is still in equilibrium. Bitwise identical on any
// number of ranks.
class AitkenAcceleration {
 public:
  AitkenAcceleration(const Mesh& mesh, const StaticSolver& solver)
      : solver_(solver), increment_(mesh.lattice.components(), mesh.nodes()), last_(increment_) {}

  void apply(int iteration, Nodal& displacement) {
    constexpr int patient = 60, pause = 20;  // iterations; most solves converge before
    if (iteration < patient) return;
    add(displacement, -1, last_, increment_);
    const double length = std::sqrt(solver_.squared(increment_));
    const double rate = before_ > 0 ? length / before_ : 0;
    before_ = length;
    // Least ratio; of the remainder of the series; largest multiple of the increment.
    constexpr double slow = 0.8, fraction = 0.8, farthest = 200;
    if (iteration % pause == 0 && rate > slow && rate < 1) {
      add(displacement, std::min(fraction * rate / (1 - rate), farthest), increment_, displacement);
      before_ = 0;
    }
    last_ = displacement;
  }

 private:
  static void add(const Nodal& a, double factor, const Nodal& b, Nodal& to) {
    for (std::size_t c = 0; c < to.of.size(); ++c)
      for (std::size_t n = 0; n < to.of[c].size(); ++n)
        to.of[c][n] = a.of[c][n] + factor * b.of[c][n];
  }

  const StaticSolver& solver_;
  Nodal increment_, last_;  // m, of the last iteration; displacement at its end
  double before_ = 0;       // m, norm of the previous increment; 0: not known
};

}  // namespace

// Collective. Solves K r = F_0 + weight with the static boundary conditions. In an elastic ground r
// only contributes to static stresses: the motion is measured from it and does not depend on it.
bool Ground::Impl::settle(std::span<const Vec3> top_force, const StaticMonitor& monitor) {
  // The present shape remains the shape of the surface, and is the reference from now on.
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) state.offset[c][n] += state.displacement[c][n];
  for (Nodal* values :
       {&state.displacement, &state.velocity, &state.acceleration, &state.one_before,
        &state.two_before, &state.internal, &state.load, &state.settled})
    values->fill(0);
  time = 0;
  if (free_field) free_field->reset();
  // With nothing settled yet the load is the whole force: the new F_0, bitwise identical to what
  // set_load subtracts later, so that the same force yields exactly zero.
  set_load(top_force);
  std::swap(state.settled, state.load);

  Nodal right = state.settled;
  // Weight acts on the last component, z, in a plane model too.
  const int up = components() - 1;
  for (const std::int32_t n : mesh.own) right[up][n] -= terms.weight(static_cast<std::size_t>(n));
  if (plasticity && !yielding_equilibrium(right, monitor)) return false;
  if (!plasticity) elastic_equilibrium(right);
  mesh.exchange(state.static_displacement);
  mesh.exchange(state.offset);
  refresh_surface();
  return true;
}

// Plain K: damping and mass do not affect equilibrium.
LinearSystem::Spec Ground::Impl::static_spec() const {
  LinearSystem::Spec spec{std::vector<double>(mesh.solids.solid.size(), 1.0),
                          Nodal(components(), mesh.nodes()), terms.held_static,
                          parameters.tolerance};
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components(); ++c) spec.diagonal[c][spring.node] += spring.stiffness;
  return spec;
}

// Collective. The static solve of a yielding ground does not use PETSc (static_solver.hpp).
void Ground::Impl::try_solvers(double dt) {
  if (!plasticity) LinearSystem(mesh, stiffness, static_spec());
  if (parameters.integrator == Integrator::explicit_) return;
  prepare_window(dt, alpha_scheme(parameters));
  if (plasticity) implicit_->try_changed();
}

void Ground::Impl::elastic_equilibrium(const Nodal& right) {
  const auto timing = timers->scope(Phase::ground_solve);
  LinearSystem statics(mesh, stiffness, static_spec());
  // The old static solution is the first guess: settling again under nearly the same load is cheap.
  iterations += statics.solve(right, state.static_displacement);
  ++solves;
}

bool Ground::Impl::yielding_equilibrium(const Nodal& right, const StaticMonitor& monitor) {
  const std::int64_t patience = parameters.static_iterations;
  StaticSolver solver(mesh, stiffness, terms);
  AitkenAcceleration acceleration(mesh, solver);
  const Nodal none(components(), mesh.nodes());
  // Forces of the plastic strain, relative to the internal force: before and after its increment.
  Nodal before(components(), mesh.nodes()), after = before, load = right;
  const double all = std::sqrt(solver.squared(right));
  // While the out-of-balance force is large a rough solution suffices: its residual over that
  // force.
  constexpr double rough = 0.02;
  // Return mappings per iteration: enhanced strains follow at almost no cost, and the number of
  // iterations decreases by a third.
  constexpr int returns = 4;
  double residual = 1, milestone = 2, reached = 1;
  plasticity->begin_static();
  plasticity->act_on(after);
  const double fine = std::max(parameters.tolerance, rough * enough);
  for (int iteration = 0; residual > enough || reached > fine; ++iteration) {
    if (iteration % patience == 0) {
      if (residual > enough && residual > 0.5 * milestone)
        throw RunError(divergence(iteration, patience, residual));
      milestone = residual;
    }
    before = after;
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t own : mesh.own) load[c][own] = right[c][own] - before[c][own];
    // The first iteration is the elastic solution, which is final if nothing yields.
    reached =
        iteration == 0 ? parameters.tolerance : std::max(parameters.tolerance, rough * residual);
    {
      const auto timing = timers->scope(Phase::ground_solve);
      iterations += solver.solve(load, state.static_displacement, reached, all);
    }
    ++solves;
    acceleration.apply(iteration, state.static_displacement);
    {
      const auto timing = timers->scope(Phase::ground_plasticity);
      for (int k = 0; k < returns; ++k) plasticity->flow(state.static_displacement, none);
    }
    after.fill(0);
    plasticity->act_on(after);
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t own : mesh.own) load[c][own] = after[c][own] - before[c][own];
    residual = all > 0 ? std::sqrt(solver.squared(load)) / all : 0;
    if (monitor && !monitor(iteration + 1, residual)) return false;
  }
  plasticity->end_static();
  return true;
}

}  // namespace trackbed::fem
