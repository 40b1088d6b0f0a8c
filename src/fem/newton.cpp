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
// Ten are many; what still grows then has no end.
constexpr int most_rounds_of_a_step = 50;

std::string no_end(int rounds, double left, std::int64_t lost) {
  const std::string why =
      lost > 0
          ? fmt::format("in {} zones no stress fits both their strain and their strength", lost)
          : fmt::format("{:.2g} of its forces are out of balance", left);
  return fmt::format(
      "the ground finds no end of an implicit step: after {} rounds of Newton {}; take a shorter "
      "time.window, integrator = \"explicit\", or layers that carry what lies on them",
      rounds, why);
}

}  // namespace

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
  const double all = implicit_->residual(mixed_, newton_step_, residual_);
  const double enough = looser * parameters.tolerance * all + rounding;
  const double share = (1 - s.alpha_f) * s.beta * dt * dt;
  const auto add = [&](const LinearSystem::Add& to) {
    plastic_step_->tangent(
        [&](std::size_t zone, const Eigen::MatrixXd& k) { to(zone, share * k); });
  };
  left.clear();
  ++newton_steps;
  Nodal& a = state.acceleration;
  iterations += implicit_->solve(mixed_, a, rounding);
  double open = out_of_balance(dt, s, a);
  for (int round = 1;; ++round) {
    ++solves, ++rounds;
    most_rounds = std::max<std::int64_t>(most_rounds, round);
    left.push_back(all > 0 ? open / all : 0);
    const std::int64_t lost = mesh.comm.sum(static_cast<std::int64_t>(plastic_step_->lost()));
    if (lost == 0 && open <= enough) break;
    const bool stuck = lost > 0 && open <= enough;  // no step would change it
    if (stuck || round == most_rounds_of_a_step || !std::isfinite(open))
      throw RunError(no_end(round, left.back(), lost));
    const double exact = std::max(std::min(open / all, 1e-2), 0.1 * enough / open);
    const int spent = implicit_->solve_changed(add, residual_, exact, newton_step_);
    if (spent < 0) throw RunError(no_end(round, left.back(), lost));
    iterations += spent;
    open = line_search(dt, s, newton_step_, open);
  }
  plastic_step_->keep(blend_);
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
