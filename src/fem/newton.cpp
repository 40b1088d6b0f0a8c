// Implicit steps of a ground that yields: Newton's method on the accelerations at the end.
//
// With P(u) the force of the plastic strain that the motion at the end leaves (plastic_step.hpp)
// and the rest of the equation as in implicit.cpp,
//   r(a') = right + f P(u') + alpha_f P(u) - A a' = 0,  dr/da' = -A + f beta dt^2 dP/du.
// So forces are weighted between begin and end as the scheme does, and stresses lie on the surface
// at the end. A step in which nothing flows is the elastic one, to the bit.
//
// The first round is that step, with the plastic strain of the begin: a guess carried on from the
// windows before may lie beyond the strength where the end does not, and what flows there in
// thought can balance as well.
//
// The linear solves are as exact as the order asks for: the residual they leave falls with the one
// they begin with (Dembo, Eisenstat, Steihaug 1982, doi:10.1137/0719025). A step of Newton that
// makes the residual grow is shortened. What does not converge ends the run: time steps are the
// deck's, and shorter ones taken here in silence would be another run than the one asked for.
//
// Without a potential (dilation below friction) a zone may have several ends, or one that jumps as
// its nodes move, and rounds go in circles about the jump. Such a step is taken anew with enhanced
// strains that follow what flows in the next one, as they do in all explicit steps: stresses of its
// end then lie beyond the strength by what the next step takes back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Rounds end at this many times the tolerance of linear solves, which would else have to be met by
// stresses in corners of the surface. Mostly the last round leaves far less.
constexpr double looser = 100;
// Ten are many. Where enhanced strains follow at once, rounds that have not come to an end by then
// go in circles; else it is worth waiting for.
constexpr int most_rounds_at_once = 20, most_rounds_of_a_step = 50;
// Beyond it strains are not those of small displacements, whatever balances.
constexpr double largest_strain = 1;
// Of a step whose enhanced strains lag. Explicit steps gain less; a collapse, which such a step
// would carry by stresses beyond the strength, gains tens of times as much.
constexpr double largest_gain = 0.02;

}  // namespace

std::string Ground::Room::no_end(const NewtonStep& step) {
  if (step.ended)
    return fmt::format(
        "the ground flows apart: plastic strains reach {:.2g} at the end of an implicit step, and "
        "elements of small displacements know none above {:g}; take layers that carry what lies "
        "on them, or a weaker wave or load",
        step.strain, largest_strain);
  const std::string why =
      step.lost > 0 ? fmt::format("in {} zones no stress fits both their strain and their strength",
                                  step.lost)
                    : fmt::format("{:.2g} of its forces are out of balance", step.left);
  return fmt::format(
      "the ground finds no end of an implicit step: after {} rounds of Newton {}; take a shorter "
      "time.window, integrator = \"explicit\", or layers that carry what lies on them",
      step.rounds, why);
}

// Lets the zones flow to the end that these accelerations give, into residual_ what is then
// missing. Afterwards right_ of the equation with the present plastic strain is in mixed_.
double Ground::Room::out_of_balance(double dt, const AlphaScheme& s, const Nodal& acceleration) {
  const double reach = s.beta * dt * dt, f = 1 - s.alpha_f;
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      blend_[c][n] = state.displacement[c][n] + reach * acceleration[c][n];
  mesh.exchange(blend_);
  plastic_step_->flow(state.rest, blend_);
  end_force_.fill(0);
  plasticity->act_on(end_force_);
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own)
      mixed_[c][n] = right_[c][n] - f * end_force_[c][n] - s.alpha_f * begin_force_[c][n];
  return implicit_->residual(mixed_, acceleration, residual_);
}

// state.displacement holds u*, state.acceleration the first guess and at last the solution;
// `rounding` is that of the right side, N.
void Ground::Room::newton(double dt, const AlphaScheme& s, double rounding) {
  if (!plastic_step_) {
    plastic_step_ = std::make_unique<PlasticStep>(mesh, *plasticity);
    for (Nodal* scratch : {&begin_force_, &end_force_, &residual_, &newton_step_, &search_from_})
      *scratch = Nodal(components(), mesh.nodes());
  }
  begin_force_.fill(0);
  plasticity->act_on(begin_force_);
  // What the forces of this step are measured by: those without more plastic strain, as in an
  // elastic step.
  for (int c = 0; c < components(); ++c)
    for (const std::int32_t n : mesh.own) mixed_[c][n] = right_[c][n] - begin_force_[c][n];
  newton_step_.fill(0);
  NewtonStep step{dt, s, rounding};
  step.all = implicit_->residual(mixed_, newton_step_, residual_);
  ++newton_steps;
  iterations += implicit_->solve(mixed_, state.acceleration, rounding);
  if (plastic_step_->has_potential()) {
    if (!comes_to_an_end(step, PlasticStep::Follow::at_once, most_rounds_of_a_step))
      throw RunError(no_end(step));
  } else {
    const Nodal first = state.acceleration;
    if (!comes_to_an_end(step, PlasticStep::Follow::at_once, most_rounds_at_once)) {
      const NewtonStep before = step;
      step.tried = step.rounds;
      state.acceleration = first;
      if (!comes_to_an_end(step, PlasticStep::Follow::next_step, most_rounds_of_a_step) ||
          mesh.comm.max(plastic_step_->largest_gain()) > largest_gain)
        throw RunError(no_end(before));
      ++lagging_steps;
    }
  }
  plastic_step_->keep(blend_);
}

// Whether rounds, so many at most, come to an end that is one of small displacements.
bool Ground::Room::comes_to_an_end(NewtonStep& step, PlasticStep::Follow when, int most) {
  plastic_step_->follow(when);
  step.ended = newton_rounds(step, most);
  step.strain = mesh.comm.max(plastic_step_->largest_strain());
  return step.ended && step.strain <= largest_strain;
}

// Returns whether they end.
bool Ground::Room::newton_rounds(NewtonStep& step, int most) {
  const double enough = looser * parameters.tolerance * step.all + step.rounding;
  const double share = (1 - step.scheme.alpha_f) * step.scheme.beta * step.dt * step.dt;
  const auto add = [&](const LinearSystem::Add& to) {
    plastic_step_->tangent(
        [&](std::size_t zone, const Eigen::MatrixXd& k) { to(zone, share * k); });
  };
  left.clear();
  double open = out_of_balance(step.dt, step.scheme, state.acceleration);
  for (step.rounds = 1;; ++step.rounds) {
    ++solves, ++rounds;
    most_rounds = std::max<std::int64_t>(most_rounds, step.tried + step.rounds);
    left.push_back(step.all > 0 ? open / step.all : 0);
    step.left = left.back();
    step.lost = mesh.comm.sum(static_cast<std::int64_t>(plastic_step_->lost()));
    if (step.lost == 0 && open <= enough) return true;
    const bool stuck = step.lost > 0 && open <= enough;  // no step would change it
    if (stuck || step.rounds == most || !std::isfinite(open)) return false;
    const double exact = std::max(std::min(open / step.all, 1e-2), 0.1 * enough / open);
    const int spent = implicit_->solve_changed(add, residual_, exact, newton_step_);
    if (spent < 0) return false;
    iterations += spent;
    open = line_search(step.dt, step.scheme, newton_step_, open);
  }
}

// The longest of 1, 1/2, 1/4 ... of the step that makes the residual fall; the last one otherwise,
// since a corner of the surface may have to be passed.
double Ground::Room::line_search(double dt, const AlphaScheme& s, const Nodal& step, double open) {
  constexpr double shortest = 1.0 / 64;
  search_from_ = state.acceleration;
  for (double length = 1;; length *= 0.5) {
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t n : mesh.own)
        state.acceleration[c][n] = search_from_[c][n] + length * step[c][n];
    const double now = out_of_balance(dt, s, state.acceleration);
    if (now < open || length <= shortest) return now;
  }
}

}  // namespace trackbed::fem
