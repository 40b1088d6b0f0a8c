// Time steps. Three things limit them: the stiffest contact of the lightest stone (sub-step), the
// ground's elements (its own steps within a window) and the staggered coupling (window). The first
// two are asked of the rooms; the third is ours. Nothing here depends on ranks or on the machine,
// so a run has the same windows everywhere.
#include "app/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "app/world.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;  // relative, so that a given step equal to the limit passes

// Sensible also for decks with problems: these functions run while problems are being collected.
double positive(double value, double instead) { return value > 0 ? value : instead; }

double sieve_low(const Model& model) {
  const auto& sieve = model.bed.sieve;
  return sieve.empty() ? 0.02 : positive(sieve.front(), 20) * 1e-3;
}

double lightest_material(const Model& model) {
  double density = infinite;
  for (const auto& material : model.physics.materials)
    if (material.density > 0) density = std::min(density, material.density);
  return std::isfinite(density) ? density : 2600;
}

double top_node_mass(const Model& model) {
  const auto& ground = model.ground;
  double density = infinite;
  for (const auto& layer : ground.layers)
    if (layer.solid.density > 0) density = std::min(density, layer.solid.density);
  if (!std::isfinite(density) || ground.x.size() != 2 || ground.y.size() != 2) return infinite;
  double depth = 0;
  for (const auto& layer : ground.layers) depth += positive(layer.thickness, 0);
  const auto cells = [](std::int64_t n) {
    return static_cast<double>(std::max<std::int64_t>(n, 1));
  };
  const double dx = (ground.x[1] - ground.x[0]) / cells(ground.zones_x);
  const double dy = model.dimension == Dimension::plane
                        ? model.thickness
                        : (ground.y[1] - ground.y[0]) / cells(ground.zones_y);
  const double dz = depth / cells(ground.zones_z);
  const double mass = density * dx * dy * dz / 2;
  return mass > 0 ? mass : infinite;
}

}  // namespace

double stiffest_contact(const Model& model) {
  double k = 0;
  const double size = model.bed.sieve.empty() ? 0.06 : positive(model.bed.sieve.back(), 60) * 1e-3;
  for (const auto& law : model.physics.laws)
    if (law.kind == dem::LawKind::linear) k = std::max(k, law.k_n);
  // Hertz: dF/ddelta = 2 E* sqrt(R delta), E* = E / (2 (1 - nu^2)) of equal materials (Johnson
  // 1985).
  for (const auto& material : model.physics.materials) {
    const double e_star = material.young / (2 * (1 - material.poisson * material.poisson));
    k = std::max(k, 2 * e_star * 0.5 * size * std::sqrt(1e-3));
  }
  return positive(k, 1e6);
}

double rough_step_limit(const Model& model) {
  const double d = sieve_low(model);
  const double shape = 1 / std::clamp(model.bed.elongation, 0.1, 1.0);
  const double volume = model.dimension == Dimension::plane
                            ? std::numbers::pi / 4 * d * d * shape * positive(model.thickness, 1)
                            : std::numbers::pi / 6 * d * d * d * shape * shape;
  const double mass = lightest_material(model) * volume;
  return positive(model.dem.safety, 0.2) * std::sqrt(mass / stiffest_contact(model));
}

double coupling_limit(const Model& model, bool ground_moves) {
  double mass = infinite;
  if (model.ground.present && ground_moves) mass = top_node_mass(model);
  if (model.has_stage(StageKind::sleepers)) {
    const auto& s = model.sleepers;
    const double length = model.dimension == Dimension::plane ? model.thickness : s.length;
    const double sleeper = s.density * s.width * s.height * length;
    if (sleeper > 0) mass = std::min(mass, sleeper);
  }
  return 0.5 * std::sqrt(mass / stiffest_contact(model));
}

Steps choose_steps(const World& world, const Model& model, const Stage& stage,
                   const input::Deck& deck) {
  std::string dem_words, ground_words;
  const double dem_limit = world.particles.stable_step(&dem_words);
  if (model.time.step > dem_limit * (1 + rounding))
    throw InputError({fmt::format("{} = {:g} s is above the stable sub-step of {:.4g} s ({})",
                                  deck.where("time.step"), model.time.step, dem_limit, dem_words)});
  const double step = model.time.step > 0 ? model.time.step : dem_limit;
  const double coupling = coupling_limit(model, stage.ground_moves);
  Steps steps;
  steps.window = step * static_cast<double>(model.time.substeps);
  steps.limit = "stones: " + dem_words;
  if (stage.ground_moves && world.ground) {
    // No limit of the window: the ground divides it into as many steps as it needs.
    const double ground = world.ground->stable_step(&ground_words);
    if (ground < steps.window)
      steps.limit += fmt::format("; ground in steps of at most {:.4g} s: {}", ground, ground_words);
  }
  if (coupling < steps.window) {
    steps.window = coupling;
    steps.limit = "coupling: contact stiffness and mass of what the stones touch";
  }
  if (model.time.window > 0) {
    if (model.time.window > coupling * (1 + rounding))
      throw InputError({fmt::format("{} = {:g} s is above the stable window of {:.4g} s",
                                    deck.where("time.window"), model.time.window, coupling)});
    steps.window = model.time.window, steps.limit = "given";
  }
  if (!std::isfinite(steps.window))
    throw InputError({fmt::format("{}: stage \"{}\" has nothing that moves, so no time step",
                                  deck.where("stage"), stage.name)});
  steps.substeps = std::max(1, static_cast<int>(std::ceil(steps.window / step * (1 - rounding))));
  return steps;
}

}  // namespace trackbed::app
