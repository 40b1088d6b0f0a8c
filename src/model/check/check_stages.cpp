// The bed is filled, since the number of stones and their smallest mass are known only then. Memory
// is that after the first fill; contacts add to it later.
#include <fmt/format.h>

#include <algorithm>

#include "model/check/comparison.hpp"
#include "model/check/estimate.hpp"
#include "model/check/placed_check.hpp"
#include "model/check/scaling.hpp"
#include "model/scheme/staged_log.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/checks.hpp"

namespace trackbed::model {

namespace {

// Stones that a stage of kind fill pours; 0: they are copies of a cell.
std::int64_t count_of(const StonesOfLayers& stones, const Stage& fill) {
  const auto layer = stones.find(fill.layer);
  return layer == stones.end() ? 0 : layer->second.count;
}

// Placing them would take more than some 10 s.
constexpr std::int64_t most_placed = 2'000'000;

}  // namespace

void check_stages(const par::Comm& comm, const Model& model, const StagesToCheck& given) {
  World world(comm, model);
  if (world.placement) world.placement->give_shapes(given.placed.shapes);
  StageActions actions(world, model);
  say_model(world, given.name);
  if (!given.ground.empty()) say(comm, given.ground);
  if (const std::string words = words_of_comparison(model); !words.empty()) say(comm, words);
  if (world.ground) observe::Sensors(comm, model.sensors, model.dem.gravity).locate(*world.ground);
  const auto megabytes = [&] { return static_cast<double>(world.memory()) / (1024 * 1024); };
  double memory = megabytes();
  std::string problem;
  const char* later = model.has_stones() ? "; contacts of stones will need more" : "";
  // After a start from a checkpoint the remaining work depends on stones that only a run loads.
  if (!model.has_stones()) {
    for (const std::string& line : estimate_alone(world)) say(comm, line);
  } else if (model.is_placed()) {
    for (const std::string& line : estimate_placed(world, given.deck)) say(comm, line);
    memory = megabytes();
  } else if (given.start.empty() && model.stages.front().kind == StageKind::fill) {
    const bool more = std::count_if(model.stages.begin(), model.stages.end(),
                                    [](const Stage& s) { return s.kind == StageKind::fill; }) > 1;
    const char* which = more ? " of the first layer" : "";
    const std::int64_t count = count_of(given.stones, model.stages.front());
    if (count > most_placed) {
      say(comm, fmt::format("  stones{}: {}, not placed here since they are more than {}", which,
                            count, most_placed));
      later = ", without the stones";
    } else {
      actions.begin(model.stages.front());
      memory = megabytes();
      const dem::Totals totals = world.particles.totals();
      say(comm, fmt::format("  stones{}: {} ({} pieces), {:.0f} kg", which, totals.particles,
                            totals.pieces, totals.mass));
    }
    const Estimate found = estimate(world, actions, given.stones, given.deck);
    for (const std::string& line : found.lines) say(comm, line);
    problem = found.problem;
    if (!given.ranks.empty())
      for (const std::string& line : scaling_of(world, given.ranks, found.step_time))
        say(comm, line);
  } else {
    say(comm, "  stones: as in " + given.start + "");
  }
  say(comm,
      fmt::format("memory of the model before the first window: at most {:.2g} MB on a rank{}",
                  comm.max(memory), later));
  if (!problem.empty())
    throw InputError(
        {given.name + ": the first windows of the bed as it is laid fail: " + problem});
}

}  // namespace trackbed::model
