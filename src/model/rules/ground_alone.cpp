// A ground alone uses the run of a bed without its other parts: no stones, no walls, nothing in
// contact with its top. Stages, output, checkpoints and resume are therefore those of a bed.
// Rejected: a separate run beside those of beds and tracks, most of which would be the same code.
#include "model/rules/ground_alone.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "model/rules/rules.hpp"
#include "trackbed/core/whole_steps.hpp"

namespace trackbed::model {

namespace {

// m, range in x that a moving rectangle covers during the run.
std::array<double, 2> covered_range(const Model& model, const PressureParameters& p) {
  const double travel = p.speed * model.duration();
  return {p.x[0] + std::min(travel, 0.0), p.x[1] + std::max(travel, 0.0)};
}

// A parameter of a pressure, and why the pressure cannot act at this position; no reason if it can.
struct Misplaced {
  const char* key;
  std::string why;
};

// A moving pressure may enter and leave the ground.
Misplaced misplaced(const Model& model, const PressureParameters& p, const std::vector<double>& x,
                    const std::vector<double>& y) {
  const auto outside = [](const auto& inner, const std::vector<double>& outer) {
    return inner[0] < outer[0] - same_length || inner[1] > outer[1] + same_length;
  };
  if (p.speed == 0 && outside(p.x, x))
    return {"x", fmt::format("reaches beyond the top of the ground ({:g} to {:g} m)", x[0], x[1])};
  const auto [from, to] = covered_range(model, p);
  if (!model.ground.periodic(0) && (to <= x[0] || from >= x[1]))
    return {"x",
            fmt::format("moves from x = {:g} to {:g} m and is never on the ground ({:g} to {:g} m)",
                        from, to, x[0], x[1])};
  if (model.dimension == Dimension::space && p.y.size() == 2 && outside(p.y, y))
    return {"y", fmt::format("reaches beyond the top of the ground ({:g} to {:g} m)", y[0], y[1])};
  return {"x", ""};
}

bool has_place(const PressureParameters& p) {
  return p.x.size() == 2 && (p.y.empty() || p.y.size() == 2);
}

void declare_steps(const Model& model, input::Section& s) {
  const bool implicit = model.ground.integrator != fem::Integrator::explicit_;
  s.rule("time.window", !implicit || model.time.window > 0,
         "must be given for an implicit ground (ground.integrator): each window is one step",
         {.reads = {"time.window", "ground"}});
  const TimeParameters none;
  const Output output;
  const auto is_default = [&](double interval) {
    return interval == output.history_interval || interval == output.checkpoint_interval;
  };
  for (const Stage& stage : model.stages)
    s.rule("time.window", stage.duration <= 0 || model.time.window <= stage.duration,
           fmt::format("is longer than stage \"{}\" ({:g} s), which then lasts one window",
                       stage.name, stage.duration),
           {.severity = input::Severity::warning, .reads = {"time.window", "stage"}});
  for (const auto& [key, idle] : {std::pair{"time.step", model.time.step == none.step},
                                  {"time.substeps", model.time.substeps == none.substeps}})
    s.rule(key, idle, "has no effect without stones: give time.window",
           {.severity = input::Severity::warning, .reads = {key}});
  for (const auto& [key, interval] :
       {std::pair{"output.history_interval", model.output.history_interval},
        {"output.fields_interval", model.output.fields_interval},
        {"output.checkpoint_interval", model.output.checkpoint_interval}})
    s.rule(key,
           interval == 0 || is_default(interval) ||
               interval >= model.time.window * (1 - rounding_of_steps),
           fmt::format(
               "is less than a time window ({:g} s): output is then written after every window",
               model.time.window),
           {.severity = input::Severity::warning, .reads = {key, "time"}});
}

// Parameters that act only on stones.
void declare_idle(const Model& model, input::Section& s) {
  const Stage none;
  const auto idle = [&](const std::string& key, bool given) {
    s.rule(key, !given, "has no effect without stones",
           {.severity = input::Severity::warning, .reads = {key}});
  };
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const std::string key = fmt::format("stage[{}].", i);
    idle(key + "until_ratio", stage.until_ratio != none.until_ratio);
    idle(key + "local_damping", stage.local_damping != none.local_damping);
    idle(key + "friction", stage.friction != none.friction);
    idle(key + "stiffness", stage.stiffness != none.stiffness);
  }
  idle("output.surface_cell", model.output.surface_cell != Output().surface_cell);
}

// Implicit steps that do not resolve a load in time or in its travel: each step uses the load at
// its end.
void declare_resolved(const Model& model, const PressureParameters& p, const std::string& key,
                      input::Section& s) {
  constexpr double fewest = 4;  // windows: zero, rise, peak, fall
  if (model.ground.integrator == fem::Integrator::explicit_) return;
  const double window = model.time.window;
  const auto resolved = [&](const std::string& name, bool holds, const std::string& what) {
    s.rule(key + name, holds,
           fmt::format("{}; give a shorter time.window (now {:g} s)", what, window),
           {.severity = input::Severity::warning, .reads = {key, "time", "ground"}});
  };
  const bool runs = p.course == PressureCourse::rise || p.course == PressureCourse::pulse;
  resolved(".duration", !runs || p.duration == 0 || p.duration >= fewest * window,
           fmt::format("is less than {:g} windows", fewest));
  resolved(".frequency",
           p.course != PressureCourse::harmonic ||
               p.frequency * fewest * window <= 1 + rounding_of_steps,
           fmt::format("gives cycles of {:g} s, less than {:g} windows",
                       p.frequency > 0 ? 1 / p.frequency : 0, fewest));
  resolved(".speed", std::abs(p.speed) * window <= p.x[1] - p.x[0],
           fmt::format("moves the pressure in a window by {:g} m, more than its length of {:g} m",
                       std::abs(p.speed) * window, p.x[1] - p.x[0]));
}

}  // namespace

void declare_stages_alone(const Model& model, input::Section& s) {
  declare_names_of_stages(model, s);
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const std::string key = fmt::format("stage[{}].", i);
    s.rule(key + "kind", model.stages[i].kind == StageKind::run,
           "must be \"run\": a ground alone has no other kind of stage", {.reads = {key + "kind"}});
    s.rule(key + "ground_moves", model.stages[i].ground_moves,
           "must be true: nothing else moves in a model of kind ground",
           {.reads = {key + "ground_moves"}});
  }
  declare_uses_of_stages(model, s);
  declare_idle(model, s);
  s.rule("ground.present", model.ground.present, "must be true for model = \"ground\"",
         {.reads = {"ground.present"}});
  if (!model.ground.present) return;
  declare_idle_sides(model.ground, model.dimension, s);
  declare_ground_yields(model, s);
  declare_steps(model, s);
  s.rule("dimension", model.dimension == Dimension::space || !model.ground.of_tetrahedra(),
         "must be \"space\": a ground of tetrahedra is three-dimensional (ground.mesh, "
         "ground.section)",
         {.reads = {"dimension", "ground"}});
  const bool loaded = std::any_of(model.pressures.begin(), model.pressures.end(),
                                  [](const auto& p) { return p.course != PressureCourse::dead; });
  s.rule("pressure", loaded || !model.ground.base_motion.empty(),
         fmt::format("nothing moves the ground: {}, and there is no incoming wave "
                     "(ground.base_motion)",
                     model.pressures.empty() ? "there are no pressures"
                                             : "all pressures have course = \"dead\", under which "
                                               "the ground is initially in static equilibrium"),
         {.severity = input::Severity::warning, .reads = {"pressure", "ground"}});
}

void declare_pressures(const Model& model, input::Section& s) {
  const input::About about{.reads = {"pressure", "model"}};
  if (model.kind != ModelKind::ground)
    return s.rule("pressure", model.pressures.empty(),
                  "is only for model = \"ground\": in other models, the bed or the track loads "
                  "the ground",
                  about);
  const fem::GroundParameters& ground = model.ground;
  declare_names_of_pressures(model, s);
  for (std::size_t i = 0; i < model.pressures.size(); ++i) {
    const PressureParameters& p = model.pressures[i];
    const std::string key = fmt::format("pressure[{}]", i);
    if (!has_place(p)) continue;  // reported by another rule
    const bool plane = model.dimension == Dimension::plane;
    s.rule(key + ".y", !plane || p.y.empty(), "has no effect in a plane model: leave it out",
           {.reads = {key, "dimension"}});
    s.rule(key + ".across", !plane || p.across == 0, "must be 0 in a plane model",
           {.reads = {key, "dimension"}});
    declare_resolved(model, p, key, s);
    const double time = model.duration();
    const bool begins = p.course != PressureCourse::dead && p.course != PressureCourse::table;
    s.rule(key + ".begin", !begins || time <= 0 || p.begin < time,
           fmt::format("is after the end of the last stage at {:g} s: the pressure has no effect",
                       time),
           {.severity = input::Severity::warning, .reads = {key, "stage"}});
    if (!ground.mesh.empty() || ground.x.size() != 2 || ground.y.size() != 2) continue;
    std::vector<double> across = ground.y;
    if (!ground.sections.empty()) {
      const auto [from, to] = covered_range(model, p);
      const double half = ground.narrowest_crest(from, to);
      across = {std::max(-half, across[0]), std::min(half, across[1])};
    }
    const auto [name, why] = misplaced(model, p, ground.x, across);
    s.rule(fmt::format("{}.{}", key, name), why.empty(), why,
           {.reads = {key, "ground", "dimension", "stage"}});
  }
}

void require_below(const Model& model, const std::array<double, 2>& x,
                   const std::array<double, 2>& y, const input::Deck& deck,
                   std::vector<std::string>& problems) {
  for (std::size_t i = 0; i < model.pressures.size(); ++i) {
    const auto [name, why] = misplaced(model, model.pressures[i], {x[0], x[1]}, {y[0], y[1]});
    if (!why.empty())
      problems.push_back(
          fmt::format("{}: {}", deck.where(fmt::format("pressure[{}].{}", i, name)), why));
  }
}

}  // namespace trackbed::model
