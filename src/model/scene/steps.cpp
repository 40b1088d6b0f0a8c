// The window is chosen once per stage; a given one that is too long is refused.
#include "model/scene/steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/rules/limits.hpp"
#include "model/scene/world.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"

namespace trackbed::model {

StonesStep step_of(const World& world) {
  StonesStep step;
  step.longest = world.particles.stable_step(&step.limit);
  return step;
}

namespace {

// The mass of the nodes of a mesh is not in the deck: it is taken from the ground itself.
CouplingLimit coupling_limit(const World& world, const Stage& stage) {
  const CouplingLimit limit = coupling_limit(world.model, stage);
  if (!stage.ground_moves || !world.ground || !world.model.ground.of_tetrahedra()) return limit;
  double lightest = std::numeric_limits<double>::infinity();
  for (const std::int32_t node : world.ground->own_top())
    lightest = std::min(lightest, world.ground->top_mass(node));
  constexpr double contacts = 1;  // as of layers
  const CouplingLimit top =
      coupling_limit(world.model, "surface node of the ground", world.comm.min(lightest), contacts);
  return top.window < limit.window ? top : limit;
}

}  // namespace

// Order: sub-step from the stones (or given), window from the number of sub-steps, limited by the
// coupling (or given), then as many sub-steps as fill the window. The final rounding shortens the
// sub-step and never lengthens it.
Steps choose_steps(const World& world, const StonesStep& stones, const Stage& stage,
                   const input::Deck& deck) {
  const Model& model = world.model;
  if (!model.has_stones()) return steps_alone(world);
  std::string ground_words;
  require_stable(model, deck, stones.longest, stones.limit);
  const double step = model.time.step > 0 ? model.time.step : stones.longest;
  const CouplingLimit coupling = coupling_limit(world, stage);
  Steps steps;
  steps.window = step * static_cast<double>(model.time.substeps);
  steps.limit = model.time.step > 0 ? "time.step" : "the stones: " + stones.limit;
  if (stage.ground_moves && world.ground) {
    // Not a limit of the window: the ground divides it into as many steps as it needs.
    const double ground = world.ground->stable_step(&ground_words);
    if (ground < steps.window)
      steps.limit += fmt::format(
          "; the ground divides each window into steps of at most {:.4g} s, limited by {}", ground,
          ground_words);
  }
  if (coupling.window < steps.window) {
    steps.window = coupling.window;
    steps.limit = "the coupling: " + coupling.words();
  }
  if (model.time.window > 0) {
    if (model.time.window > coupling.window * (1 + rounding_of_steps))
      throw InputError({fmt::format(
          "{} = {:g} s is above the longest window, {:.4g} s ({}); give at most this value{}",
          deck.where("time.window"), model.time.window, coupling.window, coupling.words(),
          model.ground.of_tetrahedra() ? "" : ", or leave it out")});
    steps.window = model.time.window, steps.limit = "time.window";
  }
  if (!std::isfinite(steps.window))
    throw InputError({fmt::format(
        "{}: nothing moves in stage \"{}\", so there is no time step; give time.window",
        deck.where("stage"), stage.name)});
  // A window is one call of the DEM, which reads no signals and writes no output.
  constexpr double most = 1e6;
  const double substeps = number_covering(steps.window, step);
  if (!(substeps <= most))
    throw InputError(
        {fmt::format("{} = {:g} s would take {:.3g} sub-steps of {:.3g} s in each "
                     "window of {:.3g} s, more than {:.0e}; give a shorter window",
                     deck.where(model.time.window > 0 ? "time.window" : "time.step"),
                     model.time.window > 0 ? model.time.window : model.time.step, substeps, step,
                     steps.window, most)});
  steps.substeps = static_cast<int>(substeps);
  return steps;
}

Steps steps_alone(const World& world) {
  Steps steps;
  const double own = world.ground->stable_step(&steps.limit);
  steps.window = world.model.time.window > 0 ? world.model.time.window : own;
  steps.limit = world.model.time.window > 0 ? "time.window" : "the ground, " + steps.limit;
  return steps;
}

}  // namespace trackbed::model
