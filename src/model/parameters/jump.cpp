#include "trackbed/model/jump.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

void JumpParameters::declare(input::Section& s) {
  s.text("from", from,
         "Name of the stage from which on cycles are counted; empty: the first stage of kind "
         "passage, or without one the first of kind load with cycles.");
  s.integer("cycles", cycles, {.at_least = 1, .at_most = 1000000},
            "Number of cycles or trains, the last ones of the stage before a jump, whose "
            "settlement is extrapolated.");
  s.number("exponent", exponent, {.unit = "-", .at_least = 0, .at_most = 1},
           "Exponent b of the law of settlement: settlement after N cycles is proportional to "
           "((1 + N)^b - 1)/b; 0: to the logarithm of 1 + N; 1: to N.");
  s.number("period", period, {.unit = "s", .above = 0, .usually_to = 10},
           "Period of the cycles of load in a jump.");
  s.number("least_friction", least_friction, {.unit = "-", .above = 0, .at_most = 0.95},
           "Least ratio of the friction coefficients in a jump to those of the contact laws: they "
           "fall from cycle to cycle until the sleepers have settled enough.");
}

double settlement_law(double cycles, double exponent) {
  const double log = std::log1p(cycles);
  return exponent > 0 ? std::expm1(exponent * log) / exponent : log;
}

std::int64_t cycles_of(const Stage& stage) {
  const bool passes = stage.kind == StageKind::passage;
  if (!passes && stage.kind != StageKind::load && stage.kind != StageKind::jump) return 0;
  return std::max<std::int64_t>(stage.cycles, passes ? 1 : 0);
}

namespace {

// The level before and after is compared under the seat force alone.
void declare_load(const Model& model, std::size_t i, input::Section& s) {
  const Stage& stage = model.stages[i];
  const auto key = [&](const char* name) { return fmt::format("stage[{}].{}", i, name); };
  const input::About about{.reads = {"jump", "stage"}};
  s.rule(key("load"), stage.load > 0, "must be above 0 N: the load of the cycles of a jump", about);
  s.rule(key("friction"), stage.friction < 0,
         "must be -1 for a jump, in which the friction of the contact laws falls", about);
  s.rule(key("settlement"), stage.settlement == 0, "is for stages of kind load and passage", about);
  s.rule(key("duration"), stage.duration >= model.jump.period,
         fmt::format("is less than a cycle of the jump (jump.period = {:g} s)", model.jump.period),
         about);
  if (i == 0) return;
  const Stage& before = model.stages[i - 1];
  s.rule(key("seat_force"), stage.seat_force == before.seat_force,
         fmt::format("must be that of the stage before, {:g} N: elastic deflection would count as "
                     "settlement",
                     before.seat_force),
         about);
  s.rule(key("load"), before.kind != StageKind::load || stage.load == before.load,
         fmt::format("must be that of the cycles before, {:g} N", before.load), about);
}

}  // namespace

const Stage* Model::counts_from() const {
  const auto first = [&](auto&& fits) -> const Stage* {
    const auto found = std::find_if(stages.begin(), stages.end(), fits);
    return found == stages.end() ? nullptr : &*found;
  };
  if (!jump.from.empty()) return first([&](const Stage& s) { return s.name == jump.from; });
  if (const Stage* passage = first([](const Stage& s) { return s.kind == StageKind::passage; }))
    return passage;
  return first([](const Stage& s) { return s.kind == StageKind::load && s.cycles > 0; });
}

// A jump needs equal cycles before it, of which it knows when the measured ones begin.
void declare_jump(const Model& model, input::Section& s) {
  const JumpParameters& jump = model.jump;
  const auto named = [&](const Stage& stage) { return stage.name == jump.from; };
  s.rule("jump.from",
         jump.from.empty() || std::any_of(model.stages.begin(), model.stages.end(), named),
         fmt::format("there is no stage \"{}\"", jump.from), {.reads = {"jump", "stage"}});
  const JumpParameters none;
  const auto idle = [&](const char* key, bool given) {
    s.rule(key, !given || model.has_stage(StageKind::jump),
           "has no effect: no stage is of kind jump",
           {.severity = input::Severity::warning, .reads = {key, "stage"}});
  };
  idle("jump.cycles", jump.cycles != none.cycles);
  idle("jump.exponent", jump.exponent != none.exponent);
  idle("jump.period", jump.period != none.period);
  idle("jump.least_friction", jump.least_friction != none.least_friction);
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    if (model.stages[i].kind != StageKind::jump) continue;
    const std::string kind = fmt::format("stage[{}].kind", i);
    const input::About about{.reads = {"jump", "stage", "breakage", "bond"}};
    const Stage* counts = model.counts_from();
    s.rule(kind, !model.start.empty() || (counts && counts < &model.stages[i]),
           "jumps over cycles that are not counted yet (jump.from)", about);
    const Stage* before = i > 0 ? &model.stages[i - 1] : nullptr;
    const bool loads =
        before && (before->kind == StageKind::load || before->kind == StageKind::passage);
    const std::int64_t cycles = loads ? cycles_of(*before) : 0;
    s.rule(kind, loads, "jumps over cycles, but the stage before is not of kind load or passage",
           about);
    // One more: the first cycle follows another load.
    s.rule(kind, !loads || cycles > jump.cycles,
           fmt::format("needs a stage of more than {} cycles before it (jump.cycles), which has {}",
                       jump.cycles, cycles),
           about);
    s.rule(kind, !loads || before->settlement == 0,
           "must not follow a stage that may end early (stage.settlement)", about);
    declare_load(model, i, s);
    s.rule(kind, !model.breakage.any() && model.bonds.empty(),
           "is not possible with breakage or bonds: it does not know what would break", about);
  }
}

}  // namespace trackbed::model
