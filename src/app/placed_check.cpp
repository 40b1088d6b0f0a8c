// The stones are made and their forces computed once, as a run would begin, and what touches too
// deeply is named by the deck's keys.
#include "app/placed_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "app/limits.hpp"
#include "app/world.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

// Of the smaller radius (of stones with corners: of their rounding). Stones at rest on each other
// have less; a deck that means more says so with dem.largest_overlap.
constexpr double noticed = 0.01;

// The deepest contact of a pair; second < 0: -1 - surface.
struct Deep {
  Id first, second;
  double overlap, radius;  // m
};

// m, smallest radius of a piece of each stone: what overlaps are measured by.
double rounding_of(const dem::Particles& particles, std::size_t i) {
  double least = std::numeric_limits<double>::infinity();
  particles.corners(i, [&](const Vec3&, double radius) { least = std::min(least, radius); });
  return least;
}

// Each pair once, in the order of ids, the same on all ranks.
std::vector<Deep> deep_contacts(const par::Comm& comm, const dem::Particles& particles,
                                std::size_t stones) {
  std::vector<double> radius(stones, 0);
  for (std::size_t i = 0; i < particles.size(); ++i)
    radius[static_cast<std::size_t>(particles[i].id)] = rounding_of(particles, i);
  comm.sum(std::span<double>(radius));
  std::vector<Deep> mine;
  particles.contacts([&](const dem::ContactView& c) {
    double least = radius[static_cast<std::size_t>(c.first)];
    if (c.second >= 0) least = std::min(least, radius[static_cast<std::size_t>(c.second)]);
    if (!(c.overlap <= noticed * least)) mine.push_back({c.first, c.second, c.overlap, least});
  });
  std::map<std::pair<Id, Id>, Deep> deepest;
  for (const Deep& d : comm.all_gather(std::span<const Deep>(mine))) {
    const auto [known, is_new] = deepest.try_emplace({d.first, d.second}, d);
    if (!is_new && d.overlap > known->second.overlap) known->second = d;
  }
  std::vector<Deep> all;
  for (const auto& [pair, deep] : deepest) all.push_back(deep);
  return all;
}

std::string sentence_of(const Deep& deep, World& world, const input::Deck& deck) {
  const auto& stones = world.model.placed.stones;
  const auto& first = stones[static_cast<std::size_t>(deep.first)];
  const auto other = [&] {
    if (deep.second >= 0)
      return fmt::format("stone \"{}\"", stones[static_cast<std::size_t>(deep.second)].name);
    const auto k = static_cast<std::size_t>(-1 - deep.second);
    return fmt::format("surface \"{}\"", world.placement->surfaces()[k].name);
  }();
  return fmt::format(
      "{}: stone \"{}\" begins {:.4g} m within {}, {:.2g} of the smaller radius (stones with "
      "corners: rounding)",
      deck.where(fmt::format("stone[{}].position", deep.first)), first.name, deep.overlap, other,
      deep.overlap / deep.radius);
}

// Keys of the deck get their place in it.
InputError placed_error(const InputError& error, const input::Deck& deck) {
  std::vector<std::string> sentences;
  for (const std::string& line : error.problems()) {
    const std::size_t colon = line.find(": ");
    const bool key = line.starts_with("stone[") && colon != std::string::npos;
    sentences.push_back(key ? deck.where(line.substr(0, colon)) + line.substr(colon) : line);
  }
  return InputError(sentences);
}

// Stones that are so fast from the begin that they may pass others, plates and boxes without a
// contact (dem/leap.cpp). How fast the others are a run sees in its first window. Collective.
std::vector<std::string> leaps(const World& world, const input::Deck& deck, double dt) {
  const PlacedParameters& placed = world.model.placed;
  std::vector<std::string> sentences;
  std::vector<dem::Leap> mine;
  if (const auto far = world.particles.leap(dt)) mine.push_back(*far);
  for (const dem::Leap& far : world.comm.all_gather(std::span<const dem::Leap>(mine)))
    sentences.push_back(fmt::format(
        "{}: stone \"{}\" goes {:.3g} m in a sub-step of {:.3g} s, more than its smallest radius "
        "of "
        "{:.3g} m: it may pass without a contact; give a smaller time.step or dem.safety",
        deck.where(fmt::format("stone[{}].velocity", far.id)),
        placed.stones[static_cast<std::size_t>(far.id)].name, far.way, dt, far.radius));
  return sentences;
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
  std::vector<std::string> problems;
  StonesToPlace found{world.placement->make_shapes(), {}};
  for (const Deep& deep : deep_contacts(comm, world.particles, model.placed.stones.size())) {
    const bool too_deep = !(deep.overlap <= model.dem.largest_overlap * deep.radius);
    (too_deep ? problems : found.warnings).push_back(sentence_of(deep, world, deck));
  }
  if (!problems.empty()) throw InputError(problems);
  const Steps steps = choose_steps(world, step_of(world), model.stages.front(), deck);
  problems = leaps(world, deck, steps.window / steps.substeps);
  if (!problems.empty()) throw InputError(problems);
  return found;
}

// Rows of the histories not counted.
std::vector<std::string> estimate_placed(World& world, const input::Deck& deck) {
  const Model& model = world.model;
  world.place_stones();
  const dem::Totals totals = world.particles.totals();
  const dem::Domain& domain = world.particles.domain();
  std::vector<std::string> lines{
      fmt::format("  stones: {} of {} pieces, {:.4g} kg; {} plate{} and {} box{}", totals.particles,
                  totals.pieces, totals.mass, model.placed.plates.size(),
                  model.placed.plates.size() == 1 ? "" : "s", model.placed.boxes.size(),
                  model.placed.boxes.size() == 1 ? "" : "es"),
      fmt::format("  domain: [{:.4g}, {:.4g}, {:.4g}] to [{:.4g}, {:.4g}, {:.4g}] m",
                  domain.low.x(), domain.low.y(), domain.low.z(), domain.high.x(), domain.high.y(),
                  domain.high.z())};
  double windows = 0;
  Steps steps;
  for (const Stage& stage : model.stages) {
    steps = choose_steps(world, step_of(world), stage, deck);
    const double needs = std::max(1.0, std::ceil(stage.duration / steps.window * (1 - 1e-9)));
    lines.push_back(
        fmt::format("  {}: {:.4g} s in {:.0f} windows of {:.4g} s in {} sub-step{} "
                    "(limit: {})",
                    stage.name, stage.duration, needs, steps.window, steps.substeps,
                    steps.substeps > 1 ? "s" : "", steps.limit));
    windows += needs;
  }
  constexpr int tried = 200;
  const auto now = std::chrono::steady_clock::now;
  const auto start = now();
  for (int k = 0; k < tried; ++k) {
    world.placement->show(k * steps.window, steps.window);
    world.coupler.publish();
    world.particles.advance(steps.window, steps.substeps);
    const dem::SurfaceAction& did = world.particles.surface_action();
    world.coupler.collect(steps.substeps, steps.window, {did.force, did.moment, did.work});
    world.placement->watch(world.particles, world.on_placed(), steps.window);
  }
  const std::chrono::duration<double> took = now() - start;
  lines.push_back(
      fmt::format("estimated wall time on {} rank{}: {:.2g} s (from {} windows; rows "
                  "of the histories not counted)",
                  world.comm.size(), world.comm.size() > 1 ? "s" : "",
                  world.comm.max(took.count()) / tried * windows, tried));
  return lines;
}

}  // namespace trackbed::app
