// Implicit steps of a yielding ground: Newton's method for the accelerations at the end.
//
// With P(u) the force of the plastic strain due to the motion at the end (plastic_step.hpp) and the
// other terms of the equation as in implicit.cpp,
//   r(a') = right + f P(u') + alpha_f P(u) - A a' = 0,  dr/da' = -A + f beta dt^2 dP/du.
// So forces are weighted between begin and end as in the scheme, and stresses are on the yield
// surface at the end. A step without plastic strain increment is exactly the elastic step.
//
// The first iteration is the elastic step with the plastic strain of the begin: a guess
// extrapolated from earlier windows may be beyond the strength although the end is not, and the
// equation may also be balanced with the fictitious plastic strain of such a guess.
//
// The tolerance of linear solves is adapted: it decreases with the residual at their start (Dembo,
// Eisenstat, Steihaug 1982, doi:10.1137/0719025). A Newton step that increases the residual is
// shortened. A step that does not converge ends the run: time steps are set by the deck, and
// shorter ones chosen here without notice would make a different run.
//
// Without a potential (dilation below friction) the equations of an element may have several
// solutions, or one that jumps as its nodes move, and the iterations then cycle about the jump.
// Such a step is solved again with lagged enhanced strains, which follow the plastic strain in the
// next step, as they do in all explicit steps: stresses at its end then exceed the strength by the
// amount that the next step corrects.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/ground/impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Iterations stop at this many times the tolerance of linear solves, which stresses in corners of
// the yield surface could not reach. Mostly the last iteration is far below it.
constexpr double looser = 100;
// Ten are many. With enhanced strains that follow at once, iterations that have not converged by
// then are cycling; otherwise more iterations are worthwhile.
constexpr int most_iterations_at_once = 20, most_iterations_of_a_step = 50;
// Beyond it strains are not small, even in equilibrium.
constexpr double largest_strain = 1;
// For a step with lagged enhanced strains. Explicit steps gain less; in a collapse, which such a
// step would prevent by stresses beyond the strength, the gain is tens of times larger.
constexpr double largest_increment = 0.02;

}  // namespace

std::string Ground::Impl::not_converged(const NewtonStep& step) {
  if (step.converged)
    return fmt::format(
        "the ground fails: plastic strains reach {:.2g} at the end of an implicit step, but the "
        "model assumes small displacements and allows at most {:g}; use stronger layers (larger "
        "cohesion or friction_angle), a weaker wave or a smaller load",
        step.strain, largest_strain);
  const std::string why =
      step.unsolved > 0
          ? fmt::format("in {} elements the return to the yield surface has no solution",
                        step.unsolved)
          : fmt::format("the relative out-of-balance force is {:.2g} (required: {:.2g})",
                        step.residual, step.enough);
  return fmt::format(
      "an implicit step of the ground did not converge in {} Newton iterations: {}; use a shorter "
      "time.window, ground.integrator = \"explicit\", or stronger layers (larger cohesion or "
      "friction_angle)",
      step.iterations, why);
}

// Updates plastic strain for these accelerations and sets residual_ to the out-of-balance force.
// Afterwards mixed_ contains the right-hand side right_ with the present plastic strain.
double Ground::Impl::out_of_balance(double dt, const AlphaScheme& s, const Nodal& acceleration) {
  const double reach = s.beta * dt * dt, f = 1 - s.alpha_f;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      blend_[c][n] = state.displacement[c][n] + reach * acceleration[c][n];
  mesh.exchange(blend_);
  plastic_step_->flow(state.static_displacement, blend_);
  end_force_.fill(0);
  plasticity->act_on(end_force_);
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      mixed_[c][n] = right_[c][n] - f * end_force_[c][n] - s.alpha_f * begin_force_[c][n];
  return implicit_->residual(mixed_, acceleration, residual_);
}

// state.displacement holds u*, state.acceleration the first guess and on return the solution;
// `rounding` is the rounding error of the right-hand side, N.
void Ground::Impl::newton(double dt, const AlphaScheme& s, double rounding) {
  if (!plastic_step_) {
    plastic_step_ = std::make_unique<PlasticStep>(mesh, *plasticity);
    for (Nodal* scratch : {&begin_force_, &end_force_, &residual_, &newton_step_, &search_from_})
      *scratch = Nodal(components(), mesh.nodes());
  }
  begin_force_.fill(0);
  plasticity->act_on(begin_force_);
  // Scale of the forces of this step: those without more plastic strain, as in an elastic step.
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) mixed_[c][n] = right_[c][n] - begin_force_[c][n];
  newton_step_.fill(0);
  NewtonStep step{dt, s, rounding};
  step.scale = implicit_->residual(mixed_, newton_step_, residual_);
  ++newton_steps;
  solve(mixed_, rounding);
  if (plastic_step_->has_potential()) {
    if (!converges(step, PlasticStep::Follow::at_once, most_iterations_of_a_step))
      throw RunError(not_converged(step));
  } else {
    const Nodal first = state.acceleration;
    if (!converges(step, PlasticStep::Follow::at_once, most_iterations_at_once)) {
      const NewtonStep before = step;
      step.earlier = step.iterations;
      state.acceleration = first;
      if (!converges(step, PlasticStep::Follow::next_step, most_iterations_of_a_step) ||
          mesh.comm.max(plastic_step_->largest_increment()) > largest_increment)
        throw RunError(not_converged(before));
      ++lagging_steps;
    }
  }
  plastic_step_->keep(blend_);
}

// Whether at most so many iterations converge to a solution with small displacements.
bool Ground::Impl::converges(NewtonStep& step, PlasticStep::Follow when, int most) {
  plastic_step_->follow(when);
  step.converged = iterate_newton(step, most);
  step.strain = mesh.comm.max(plastic_step_->largest_strain());
  return step.converged && step.strain <= largest_strain;
}

// Returns whether the iterations converge.
bool Ground::Impl::iterate_newton(NewtonStep& step, int most) {
  const double enough = looser * parameters.tolerance * step.scale + step.rounding;
  step.enough = step.scale > 0 ? enough / step.scale : 0;
  const double factor = (1 - step.scheme.alpha_f) * step.scheme.beta * step.dt * step.dt;
  const auto add = [&](const LinearSystem::Add& to) {
    plastic_step_->tangent(
        [&](std::size_t element, const Eigen::MatrixXd& k) { to(element, factor * k); });
  };
  newton_residuals.clear();
  double residual = out_of_balance(step.dt, step.scheme, state.acceleration);
  for (step.iterations = 1;; ++step.iterations) {
    ++solves, ++newton_iterations;
    most_newton_iterations =
        std::max<std::int64_t>(most_newton_iterations, step.earlier + step.iterations);
    newton_residuals.push_back(step.scale > 0 ? residual / step.scale : 0);
    step.residual = newton_residuals.back();
    step.unsolved = mesh.comm.sum(static_cast<std::int64_t>(plastic_step_->unsolved()));
    if (step.unsolved == 0 && residual <= enough) return true;
    const bool stuck = step.unsolved > 0 && residual <= enough;  // no Newton step would change it
    if (stuck || step.iterations == most || !std::isfinite(residual)) return false;
    const double relative =
        std::max(std::min(residual / step.scale, 1e-2), 0.1 * enough / residual);
    const int spent = implicit_->solve_changed(add, residual_, relative, newton_step_);
    if (spent < 0) return false;
    iterations += spent;
    residual = line_search(step.dt, step.scheme, newton_step_, residual);
  }
}

// The longest of 1, 1/2, 1/4 ... of the step that reduces the residual; otherwise the shortest one,
// since a corner of the yield surface may have to be passed.
double Ground::Impl::line_search(double dt, const AlphaScheme& s, const Nodal& step,
                                 double residual) {
  constexpr double shortest = 1.0 / 64;
  search_from_ = state.acceleration;
  for (double length = 1;; length *= 0.5) {
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t n : mesh.own)
        state.acceleration[c][n] = search_from_[c][n] + length * step[c][n];
    const double now = out_of_balance(dt, s, state.acceleration);
    if (now < residual || length <= shortest) return now;
  }
}

}  // namespace trackbed::fem
