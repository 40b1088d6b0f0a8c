// The stones are made and their forces computed once, as at the start of a run; problems are
// reported with the keys of the deck.
#include "model/check/placed_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/check/placed_begin.hpp"
#include "model/check/probe.hpp"
#include "model/scene/steps.hpp"
#include "model/scene/world.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/log.hpp"

namespace trackbed::model {

namespace {

// Adds the position in the deck to keys of the deck.
InputError placed_error(const InputError& error, const input::Deck& deck) {
  std::vector<std::string> sentences;
  for (const std::string& line : error.problems()) {
    const std::size_t colon = line.find(": ");
    const bool key = line.starts_with("stone[") && colon != std::string::npos;
    sentences.push_back(key ? deck.where(line.substr(0, colon)) + line.substr(colon) : line);
  }
  return InputError(sentences);
}

// Stones whose initial speed is so high that they may pass others, plates and boxes without a
// contact (dem/particles/leap.cpp). Speeds of the other bodies are checked in the first window of a
// run.
// Collective.
std::vector<std::string> leaps(const World& world, const input::Deck& deck, double dt) {
  const PlacedParameters& placed = world.model.placed;
  std::vector<std::string> sentences;
  std::vector<dem::FastParticle> mine;
  if (const auto far = world.particles.fast_particle(dt)) mine.push_back(*far);
  for (const dem::FastParticle& far :
       world.comm.all_gather(std::span<const dem::FastParticle>(mine)))
    sentences.push_back(fmt::format(
        "{}: stone \"{}\" moves {:.3g} m in a sub-step of {:.3g} s, more than its smallest radius "
        "of {:.3g} m: the stone may pass through others without contact; give a smaller time.step "
        "or dem.safety",
        deck.where(fmt::format("stone[{}].velocity", far.id)),
        placed.stones[static_cast<std::size_t>(far.id)].name, far.travel, dt, far.radius));
  return sentences;
}

// A stage takes whole windows: a window longer than the stage would lengthen it, and is refused.
// Collective.
void require_windows(const World& world, const input::Deck& deck) {
  std::vector<std::string> problems;
  for (const Stage& stage : world.model.stages) {
    const Steps steps = choose_steps(world, step_of(world), stage, deck);
    const double substep = steps.window / steps.substeps;
    if (&stage == &world.model.stages.front()) problems = leaps(world, deck, substep);
    if (steps.window <= stage.duration * (1 + rounding_of_steps)) continue;
    const TimeParameters& time = world.model.time;
    const bool counted = time.window == 0 && time.substeps > 1;
    problems.push_back(fmt::format(
        "{}: a window of {:.4g} s ({} sub-step{} of {:.4g} s) is longer than stage \"{}\" ({:g} "
        "s); give {}",
        deck.where(time.window > 0 ? "time.window"
                   : counted       ? "time.substeps"
                                   : "time.step"),
        steps.window, steps.substeps, steps.substeps > 1 ? "s" : "", substep, stage.name,
        stage.duration,
        substep <= stage.duration && counted
            ? fmt::format("at most {:.0f} sub-steps", std::floor(stage.duration / substep))
            : "a shorter window or a longer duration"));
  }
  if (!problems.empty()) throw InputError(problems);
}

}  // namespace

StonesToPlace require_placed(const par::Comm& comm, const Model& model, const input::Deck& deck) {
  if (!model.is_placed()) return {};
  World world(comm, model);
  try {
    world.place_stones();
  } catch (const InputError& error) {  // equal on all ranks
    throw placed_error(error, deck);
  }
  StonesToPlace found{world.placement->make_shapes(), {}};
  PlacesOfStones places = look_at_places(world, found.shapes, deck);
  if (!places.problems.empty()) throw InputError(places.problems);
  found.warnings = std::move(places.warnings);
  require_windows(world, deck);
  return found;
}

// Rows of the histories are not included.
std::vector<std::string> estimate_placed(World& world, const input::Deck& deck) {
  const Model& model = world.model;
  world.place_stones();
  const dem::Totals totals = world.particles.totals();
  const dem::Domain& domain = world.particles.domain();
  std::vector<std::string> lines{
      fmt::format("  stones: {} ({} pieces), {:.4g} kg; {} plate{} and {} box{}", totals.particles,
                  totals.pieces, totals.mass, model.placed.plates.size(),
                  model.placed.plates.size() == 1 ? "" : "s", model.placed.boxes.size(),
                  model.placed.boxes.size() == 1 ? "" : "es"),
      fmt::format("  domain: [{:.4g}, {:.4g}, {:.4g}] to [{:.4g}, {:.4g}, {:.4g}] m",
                  domain.low.x(), domain.low.y(), domain.low.z(), domain.high.x(), domain.high.y(),
                  domain.high.z())};
  double windows = 0;
  Steps steps;
  for (const Stage& stage : model.stages) {
    make_bonds(world, stage);
    steps = choose_steps(world, step_of(world), stage, deck);
    const double needs = number_covering(stage.duration, steps.window);
    lines.push_back(fmt::format(
        "  {}: {:.4g} s in {:.0f} windows of {:.4g} s with {} sub-step{} each (determined by {})",
        stage.name, stage.duration, needs, steps.window, steps.substeps,
        steps.substeps > 1 ? "s" : "", steps.limit));
    windows += needs;
  }
  int begun = 0;
  const double time = measured_time_of(world.comm, [&] {
    world.placement->update(begun++ * steps.window, steps.window);
    world.coupler.publish();
    world.particles.advance(steps.window, steps.substeps);
    world.collect_loads(steps.window, steps.substeps);
    world.placement->watch(world.particles, world.forces_on(SurfaceId::Part::placed), steps.window);
  });
  lines.push_back(fmt::format(
      "estimated wall time on {} rank{}: {} (measured in some windows; rows of "
      "the histories are not included)",
      world.comm.size(), world.comm.size() > 1 ? "s" : "", estimate_words(time * windows)));
  return lines;
}

std::vector<bed::PlacedShape> placed_shapes(const par::Comm& comm, const Model& model) {
  Placement placement(comm, model);
  return placement.make_shapes();
}

}  // namespace trackbed::model
