// Wall time is a time per stone and step, times stones and steps: measured in a bed of copies as
// they are laid, otherwise that of a table.
#include "model/check/estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "model/check/probe.hpp"
#include "model/rules/limits.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/log.hpp"

namespace trackbed::model {

namespace {

// Track, coupling and output over stones and ground, plus 1: 2 to 12 % in the runs of
// docs/scaling.md. A bed under load has more contacts than as it is laid.
constexpr double other_costs = 1.1, loaded = 1.12;
// Measured over estimated times of these runs, rounded outwards; of measured beds those of single
// stages. Without the one in which most stones split.
constexpr std::pair<double, double> spread_if_measured{0.8, 1.25}, spread_of_table{0.4, 1.8};

// Describes the steps of a stage and their limit: most stages of a deck have the same.
std::string limits_of(const Model& model, const Stage& stage, const Steps& steps) {
  std::string words =
      fmt::format("windows of {:.4g} s with {} sub-step{} each (determined by {})\n", steps.window,
                  steps.substeps, steps.substeps > 1 ? "s" : "", steps.limit);
  const CouplingLimit coupling = coupling_limit(model, stage);
  if (std::isfinite(coupling.window))
    words += fmt::format("  the coupling allows windows of at most {:.4g} s (determined by {})\n",
                         coupling.window, coupling.words());
  return words;
}

// MB of the histories of sleepers, ground, regions and sensors if all stages take their full
// duration. The rest is small or, of trains, not known here.
double size_of_histories(const Model& model, const StageActions& actions, double windows) {
  double seconds = 0;
  for (const Stage& stage : model.stages) seconds += actions.duration(stage);
  const std::vector<std::string>& parts = model.output.histories;
  const auto records = [&](std::string_view part) {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  double numbers = 0;
  if (model.uses_sleepers() && records("sleeper"))
    numbers += 5 * static_cast<double>(model.sleepers.count);
  if (model.ground.present && records("ground")) {
    const int axes = model.dimension == Dimension::plane ? 2 : 3;
    // Displacement, velocity and acceleration along each axis, and the vertical stress.
    numbers += (3 * axes + 1) * static_cast<double>(model.ground.elements_x + 1);
  }
  if (records("region"))
    for (const observe::Region& region : model.regions) {
      const auto& n = region.cells;
      const double cells = region.kind == observe::RegionKind::box ? n[0] * n[1] * n[2] : 1;
      numbers += observe::numbers_of_cell * cells;
    }
  if (records("sensor"))
    for (const observe::Sensor& sensor : model.sensors)
      numbers += observe::numbers_of_reading(sensor.kind);
  return 8e-6 * numbers * std::min(windows, seconds / model.output.history_interval);
}

// Empty if the steps are few, as usual: their cost is then small compared with that of the stones.
std::vector<std::string> warning_of_ground_steps(const World& world, double longest_window) {
  constexpr double many = 100;
  if (!world.ground || longest_window <= 0) return {};
  const double steps = longest_window / world.ground->stable_step();
  if (!(steps > many)) return {};
  return {
      fmt::format("warning: the ground takes up to {:.0f} steps of its own in each window, which "
                  "is slow; reduce "
                  "rayleigh_stiffness of ground, layers and blocks, or give larger elements",
                  steps)};
}

// A stage and what it costs at most, s of wall time: stages may end early.
struct StageCost {
  const Stage* stage;
  Steps steps;
  double windows = 0, stones = 0, ground = 0;
};

// Stones that the bed has in each stage times the time of a sub-step of one; perfect scaling over
// the ranks is assumed. The ground is measured for each length of windows in which it moves.
std::vector<StageCost> costs_of_stages(World& world, const StageActions& actions,
                                       const StonesOfLayers& stones, const input::Deck& deck,
                                       const std::vector<LayerForecast>& layers) {
  std::vector<StageCost> costs;
  std::map<double, double> ground_times;  // s of wall time by length of window, s
  std::size_t filled = 0;                 // layers
  bool trimmed = false;                   // to the profile or the sleepers
  StonesOfLayers poured;                  // up to this stage
  for (const Stage& stage : world.model.stages) {
    if (stage.kind == StageKind::fill) {
      ++filled;
      if (const auto layer = stones.find(stage.layer); layer != stones.end()) poured.insert(*layer);
    }
    trimmed = trimmed || stage.profile > 0 || stage.kind == StageKind::sleepers;
    double step_time = 0;
    for (const LayerForecast& layer : std::span(layers).first(filled))
      step_time += layer.step_time * static_cast<double>(trimmed ? layer.left : layer.made);
    const StonesStep longest =
        poured.empty() ? step_of(world) : step_of(world.model, poured, stage.stiffness);
    StageCost cost{.stage = &stage, .steps = choose_steps(world, longest, stage, deck)};
    cost.windows = actions.duration(stage) / cost.steps.window;
    cost.stones = step_time * cost.windows * cost.steps.substeps / world.comm.size();
    if (world.ground && stage.ground_moves) {
      const auto [known, is_new] = ground_times.try_emplace(cost.steps.window, 0);
      if (is_new) known->second = measured_window_of_ground(world, cost.steps.window);
      cost.ground = known->second * cost.windows;
    }
    costs.push_back(cost);
  }
  return costs;
}

// Stages with the same limits share one line.
std::vector<std::string> sentences_of(const Model& model, const std::vector<StageCost>& costs) {
  std::vector<std::string> lines;
  std::string shared, numbers;  // of the stages since the limits changed
  for (const StageCost& cost : costs) {
    const std::string limits = limits_of(model, *cost.stage, cost.steps);
    if (limits != shared && !numbers.empty()) lines.push_back(shared + "  " + numbers);
    if (limits != shared) numbers.clear();
    shared = limits;
    numbers += fmt::format("{}{} {:.0f}", numbers.empty() ? "largest number of windows: " : ", ",
                           cost.stage->name, cost.windows);
  }
  lines.push_back(shared + "  " + numbers);
  return lines;
}

std::string sentence_of_times(const std::vector<StageCost>& costs) {
  std::string line = "largest wall time, s:";
  for (const StageCost& cost : costs)
    line += fmt::format(" {} {:.3g}{}", cost.stage->name, other_costs * (cost.stones + cost.ground),
                        &cost == &costs.back() ? "" : ",");
  return line;
}

// With the spread of measured over estimated times (docs/scaling.md).
std::string sentence_of_total(const par::Comm& comm, const std::vector<StageCost>& costs,
                              bool measured, const Model& model) {
  double stones = 0, ground = 0;
  for (const StageCost& cost : costs) stones += cost.stones, ground += cost.ground;
  const double all = other_costs * (stones + ground);
  const auto [least, most] = measured ? spread_if_measured : spread_of_table;
  const std::string basis =
      measured
          ? fmt::format(
                "the stones measured as they are laid, with {:.0f} % for more contacts under load",
                100 * (loaded - 1))
          : table_of_times(model.dimension);
  return fmt::format(
      "estimated wall time on {} rank{}: {}, usually {:g} to {:g} times as much, of it {:.0f} % "
      "for the ground ({}; with {:.0f} % for track, coupling and output{}; assumes that nothing "
      "else runs on the cores and that stages have their full duration)",
      comm.size(), comm.size() > 1 ? "s" : "", estimate_words(all), least, most,
      all > 0 ? 100 * other_costs * ground / all : 0, basis, 100 * (other_costs - 1),
      model.breakage.any() ? "; without the parts of stones that break" : "");
}

// Replaces the times of the table by those of the bed of copies as it is laid. If it cannot be
// computed, a run fails as well: then returns why, otherwise nothing.
std::string measure_copies(World& world, const Steps& steps, std::vector<LayerForecast>& layers) {
  const auto count = static_cast<double>(world.particles.totals().particles);
  try {
    const double window = measured_window_of_stones(world, steps);
    for (LayerForecast& layer : layers)
      layer.step_time = window / steps.substeps / count * world.comm.size();
  } catch (const RunError& why) {
    return why.what();
  }
  return {};
}

}  // namespace

// The number of windows is an upper bound, since stages may end early.
Estimate estimate(World& world, const StageActions& actions, const StonesOfLayers& stones,
                  const input::Deck& deck) {
  const Model& model = world.model;
  std::vector<LayerForecast> layers = forecast(world, stones);
  Estimate result;
  result.lines = sentences_of(model, layers);
  std::string problem;
  const bool copies = !model.bed.cell.empty();
  if (copies)
    problem = measure_copies(world, choose_steps(world, step_of(world), model.stages.front(), deck),
                             layers);
  const bool measured = copies && problem.empty();
  auto costs = costs_of_stages(world, actions, stones, deck, layers);
  for (StageCost& cost : costs) cost.stones *= measured ? loaded : 1;
  for (const std::string& line : sentences_of(model, costs)) result.lines.push_back(line);
  result.lines.push_back(sentence_of_times(costs));
  result.lines.push_back(sentence_of_total(world.comm, costs, measured, model));
  result.problem = problem;
  double longest = 0, windows = 0;
  for (const StageCost& cost : costs) {
    windows += cost.windows;
    if (cost.stage->ground_moves) longest = std::max(longest, cost.steps.window);
  }
  for (const std::string& line : warning_of_ground_steps(world, longest))
    result.lines.push_back(line);
  result.lines.push_back(
      fmt::format("histories of sleepers, ground, regions and sensors: up to {:.2g} MB",
                  size_of_histories(model, actions, windows)));
  result.step_time = layers.front().step_time;
  return result;
}

// Starts from static equilibrium, whose solution may take long for layers that yield: not tried for
// these. Output is not included.
std::vector<std::string> estimate_alone(World& world) {
  const Model& model = world.model;
  const Steps steps = steps_alone(world);
  double windows = 0;
  for (const Stage& stage : model.stages) windows += number_covering(stage.duration, steps.window);
  std::string line = fmt::format("  {:.4g} s in {:.0f} windows of {:.4g} s (determined by {})",
                                 model.duration(), windows, steps.window, steps.limit);
  if (model.ground.yields()) return {line};
  const auto now = std::chrono::steady_clock::now;
  const auto start = now();
  std::vector<Vec3> load(world.ground->top().nodes(), Vec3::Zero());
  if (world.pressures) world.pressures->add_dead(load);
  world.ground->settle(load);
  const std::chrono::duration<double> settling = now() - start;
  int done = 0;
  const double time = measured_time_of(world.comm, [&] {
    std::fill(load.begin(), load.end(), Vec3::Zero());
    if (world.pressures) world.pressures->add(++done * steps.window, load);
    world.ground->advance(steps.window, load);
  });
  line += fmt::format(", about {} of wall time", estimate_words(settling.count() + time * windows));
  return {line};
}

}  // namespace trackbed::model
