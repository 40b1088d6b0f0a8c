// The state of rest: equilibrium under weight and settled load, elastic or not.
//
// Solids that yield: the initial stress method (Zienkiewicz, Valliappan, King 1969,
// doi:10.1002/nme.1620010107). Elastic solves under load and the forces of the plastic strain so
// far, each followed by one return of all stresses. It keeps the elastic matrix and comes to rest
// slowly near collapse. Rejected: Newton with the
// consistent tangent (unsymmetric without dilation, and bits of another solver).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rest_solver.hpp"
#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

std::string no_rest(int rounds, std::int64_t patience, double open) {
  return fmt::format(
      "no rest of the ground under its weight and what lies on it was found: after {} rounds "
      "{:.2g} of all forces still flow, more than half of what did {} rounds before; if it is to "
      "stand, give its layers more cohesion, friction_angle or tensile_strength, or, near "
      "collapse, seek longer (ground.rest_rounds)",
      rounds, open, patience);
}

// Near collapse rounds go on in one direction, each a little less far than the one before: a
// geometric series, whose rest is gone at once now and then (Aitken 1926,
// doi:10.1017/S0370164600022070). A slope with 3 % in reserve then takes 1000 rounds for 5600. What
// flows too far by it is in equilibrium all the same. The same bits on any number of ranks.
class Leaps {
 public:
  Leaps(const Mesh& mesh, const RestSolver& solver)
      : solver_(solver), way_(mesh.lattice.components(), mesh.nodes()), last_(way_) {}

  void take(int round, Nodal& rest) {
    constexpr int patient = 60, pause = 20;  // rounds; most rests are found before
    if (round < patient) return;
    add(rest, -1, last_, way_);
    const double length = std::sqrt(solver_.squared(way_));
    const double rate = before_ > 0 ? length / before_ : 0;
    before_ = length;
    constexpr double slow = 0.8, share = 0.8, farthest = 200;  // of what the series has left; ways
    if (round % pause == 0 && rate > slow && rate < 1) {
      add(rest, std::min(share * rate / (1 - rate), farthest), way_, rest);
      before_ = 0;
    }
    last_ = rest;
  }

 private:
  static void add(const Nodal& a, double factor, const Nodal& b, Nodal& to) {
    for (std::size_t c = 0; c < to.of.size(); ++c)
      for (std::size_t n = 0; n < to.of[c].size(); ++n)
        to.of[c][n] = a.of[c][n] + factor * b.of[c][n];
  }

  const RestSolver& solver_;
  Nodal way_, last_;   // m, of the last round; where it ended
  double before_ = 0;  // m, length of the way before; 0: not known
};

}  // namespace

// Collective. Solves K r = F_0 + weight with the borders of rest. In an elastic ground r only
// enters stresses at rest: the motion counts from it and never sees it.
bool Ground::Room::settle(std::span<const Vec3> top_force, const GoOn& go_on) {
  // The present shape stays the shape shown, as the reference from now on.
  for (int c = 0; c < components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) state.offset[c][n] += state.displacement[c][n];
  for (Nodal* values :
       {&state.displacement, &state.velocity, &state.acceleration, &state.one_before,
        &state.two_before, &state.internal, &state.load, &state.settled})
    values->fill(0);
  time = 0;
  if (free_field) free_field->rest();
  // With nothing settled yet the load is the whole force: the new F_0, bit for bit what set_load
  // will take off later, so that the same force leaves exactly nothing.
  set_load(top_force);
  std::swap(state.settled, state.load);

  Nodal right = state.settled;
  // Weight acts on the last component, z, in a plane as in space.
  const int up = components() - 1;
  for (const std::int32_t n : mesh.own) right[up][n] -= terms.weight(static_cast<std::size_t>(n));
  if (plasticity && !yielding_rest(right, go_on)) return false;
  if (!plasticity) elastic_rest(right);
  mesh.exchange(state.rest);
  mesh.exchange(state.offset);
  refresh_surface();
  return true;
}

// Plain K: damping and mass have no part in rest.
LinearSystem::Spec Ground::Room::rest_spec() const {
  LinearSystem::Spec spec{std::vector<double>(mesh.solids.solid.size(), 1.0),
                          Nodal(components(), mesh.nodes()), terms.held_at_rest,
                          parameters.tolerance};
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components(); ++c) spec.diagonal[c][spring.node] += spring.stiffness;
  return spec;
}

// Collective. The rest of a ground that yields is no matter of PETSc's (rest_solver.hpp).
void Ground::Room::try_solvers(double dt) {
  if (!plasticity) LinearSystem(mesh, stiffness, rest_spec());
  if (parameters.integrator == Integrator::explicit_) return;
  prepare_window(dt, alpha_scheme(parameters));
  if (plasticity) implicit_->try_changed();
}

void Ground::Room::elastic_rest(const Nodal& right) {
  LinearSystem statics(mesh, stiffness, rest_spec());
  // The old static solution is the first guess: settling twice under nearly the same load is cheap.
  iterations += statics.solve(right, state.rest);
  ++solves;
}

bool Ground::Room::yielding_rest(const Nodal& right, const GoOn& go_on) {
  // Forces of what still flows over all forces. What is left flows in the first steps.
  constexpr double enough = 1e-5;
  const std::int64_t patience = parameters.rest_rounds;
  RestSolver solver(mesh, stiffness, terms);
  Leaps leaps(mesh, solver);
  const Nodal none(components(), mesh.nodes());
  // Of the plastic strain, against the internal force: before and after it flowed.
  Nodal before(components(), mesh.nodes()), after = before, load = right;
  const double all = std::sqrt(solver.squared(right));
  // While much still flows a rough solution does: its residual over what flows.
  constexpr double rough = 0.02;
  // In a round: enhanced strains follow at next to no cost, and rounds become fewer by a third.
  constexpr int returns = 4;
  double open = 1, milestone = 2, reached = 1;
  plasticity->seek_rest();
  plasticity->act_on(after);
  const double fine = std::max(parameters.tolerance, rough * enough);
  for (int round = 0; open > enough || reached > fine; ++round) {
    if (round % patience == 0) {
      if (open > enough && open > 0.5 * milestone) throw RunError(no_rest(round, patience, open));
      milestone = open;
    }
    before = after;
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t own : mesh.own) load[c][own] = right[c][own] - before[c][own];
    // The first one is the elastic rest, which is all there is if nothing flows.
    reached = round == 0 ? parameters.tolerance : std::max(parameters.tolerance, rough * open);
    iterations += solver.solve(load, state.rest, reached, all);
    ++solves;
    leaps.take(round, state.rest);
    for (int k = 0; k < returns; ++k) plasticity->flow(state.rest, none);
    after.fill(0);
    plasticity->act_on(after);
    for (int c = 0; c < components(); ++c)
      for (const std::int32_t own : mesh.own) load[c][own] = after[c][own] - before[c][own];
    open = all > 0 ? std::sqrt(solver.squared(load)) / all : 0;
    if (go_on && !go_on(round + 1, open)) return false;
  }
  plasticity->found_rest();
  return true;
}

}  // namespace trackbed::fem
