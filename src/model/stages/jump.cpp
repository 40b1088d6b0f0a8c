// With S(N) the law of settlement, m measured cycles before cycle N and J cycles in the jump, the
// sleepers should settle, in the mean, by
//   (S(N + J) - S(N))/(S(N) - S(N - m))
// times their settlement in the measured cycles. They do so in cycles of the same load in which the
// friction of all contacts falls from one to the next until they have: contacts that slide a little
// in each cycle slide at once. Each sleeper has an aim of its own, the mean of its own settlement
// and that of all, so extrapolated: a sleeper that has reached it is loaded no more, as single ones
// would sink under low friction. The state of the bed at the end is one of stones in contact, with
// a density that belongs to the settlement. What was rejected: docs/decisions/cycle_jump.md.
#include "model/stages/jump.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace trackbed::model {

namespace {

constexpr double friction_per_cycle = 0.97;  // of that in the cycle before
// Of the settlement that is to be reached: what may lack, and what more is warned of.
constexpr double near_enough = 0.05, too_far = 0.2;

double mean(const std::vector<double>& values) {
  return values.empty() ? 0
                        : std::accumulate(values.begin(), values.end(), 0.0) /
                              static_cast<double>(values.size());
}

}  // namespace

std::vector<double> Jump::levels() const {
  std::vector<double> now;
  for (std::size_t i = 0; i < world_.sleepers->count(); ++i)
    now.push_back(world_.sleepers->state(i).displacement.z());
  return now;
}

std::vector<double> Jump::settled_since(const std::vector<double>& before) const {
  std::vector<double> by = levels();
  for (std::size_t i = 0; i < by.size(); ++i) by[i] = before[i] - by[i];
  return by;
}

// The same cycles as before the jump that precedes the stage.
bool Jump::continues(const Stage& stage) const {
  const auto at = static_cast<std::size_t>(&stage - model_.stages.data());
  if (at == 0 || noted_ < 0) return false;
  const Stage& before = model_.stages[at - 1];
  return before.kind == StageKind::jump && stage.seat_force == before.seat_force &&
         (stage.kind == StageKind::passage || stage.load == before.load);
}

// Settlement is intermittent, and the more cycles are measured the better. So those before the
// first of several jumps remain the begin of the measured ones, jumps included.
void Jump::note_levels_before_jump(const Stage& stage) {
  const auto next = static_cast<std::size_t>(&stage - model_.stages.data()) + 1;
  if (next == model_.stages.size() || model_.stages[next].kind != StageKind::jump) return;
  if (in_stage_ != static_cast<double>(cycles_of(stage) - model_.jump.cycles)) return;
  if (!continues(stage)) noted_levels_ = levels(), noted_ = counted_;
}

// Sleepers that have risen have an aim of their own of zero; the mean of all aims is that of all
// settlements.
std::vector<double> Jump::aims(double factor) const {
  std::vector<double> own = settled_since(noted_levels_);
  const double all = std::max(0.0, mean(own));
  for (double& one : own) one = std::max(0.0, one);
  const double share = all > 0 ? all / mean(own) : 0;
  for (double& one : own) one = factor * (share * one + all) / 2;
  return own;
}

std::string Jump::begin(const Stage& stage) {
  in_stage_ = 0;
  if (model_.counts_from() == &stage) counted_ = 0;
  if (stage.kind != StageKind::jump) {
    note_levels_before_jump(stage);
    return {};
  }
  const auto law = [&](double cycles) { return settlement_law(cycles, model_.jump.exponent); };
  const double to = counted_ + static_cast<double>(stage.cycles);
  levels_ = levels(), friction_ = 1;
  aims_.assign(levels_.size(), 0), rests_.assign(levels_.size(), 0);
  if (noted_ < 0) return "  no cycles have been measured: sleepers need not settle";
  const double factor = (law(to) - law(counted_)) / (law(counted_) - law(noted_));
  aims_ = aims(factor);
  return fmt::format(
      "  jump from cycle {:.0f} to {:.0f}: the sleepers should settle by {:.3g} mm in the mean, "
      "{:.4g} times as much as in the last {:.0f} cycles",
      counted_, to, 1e3 * mean(aims_), factor, counted_ - noted_);
}

void Jump::end_cycle(const Stage& stage) {
  if (counts()) ++counted_;
  ++in_stage_;
  note_levels_before_jump(stage);
}

double Jump::missing() const {
  const double aim = mean(aims_), left = aim - mean(settled_since(levels_));
  return aim > 0 && left > near_enough * aim ? left : 0;
}

bool Jump::ends_cycle(const Clock& clock) const {
  const auto cycles_at = [&](std::int64_t window) {
    return std::floor(static_cast<double>(window) * clock.dt() / model_.jump.period);
  };
  return clock.window() > 0 && cycles_at(clock.window()) != cycles_at(clock.window() - 1);
}

void Jump::watch(const Stage& stage, const Clock& clock) {
  if (stage.kind != StageKind::jump || !ends_cycle(clock) || missing() == 0) return;
  const std::vector<double> by = settled_since(levels_);
  for (std::size_t i = 0; i < by.size(); ++i)
    if (by[i] >= (1 - near_enough) * aims_[i]) rests_[i] = 1;
  friction_ = std::max(model_.jump.least_friction, friction_per_cycle * friction_);
  world_.particles.scale_friction(friction_);
}

double Jump::load(const Stage& stage, double time, std::size_t i) const {
  if (stage.kind != StageKind::jump || rests_[i] > 0) return 0;
  const double phase = 2 * std::numbers::pi * time / model_.jump.period;
  return stage.load * 0.5 * (1 - std::cos(phase));
}

bool Jump::is_over(const Stage& stage, const Clock& clock) const {
  if (stage.kind != StageKind::jump) return false;
  return mean(aims_) == 0 || (ends_cycle(clock) && missing() == 0);
}

std::string Jump::shortfall() const {
  if (noted_ < 0)
    return "no cycles have been measured before it: give a stage of cycles (jump.from)";
  const double aim = mean(aims_);
  if (missing() > 0)
    return fmt::format(
        "the sleepers should settle by {:.3g} mm in the mean and lack {:.3g} mm, with {:.3g} times "
        "the friction; give a longer stage.duration or a smaller jump.least_friction",
        1e3 * aim, 1e3 * missing(), friction_);
  const double by = mean(settled_since(levels_));
  if (by <= (1 + too_far) * aim || aim == 0) return {};
  return fmt::format(
      "the sleepers should settle by {:.3g} mm in the mean and have settled by {:.3g} mm: single "
      "ones have sunk; give shorter jumps",
      1e3 * aim, 1e3 * by);
}

// A passage without `cycles` is one train.
void Jump::end(const Stage& stage) {
  if (stage.kind == StageKind::passage && stage.cycles == 0) end_cycle(stage);
  if (stage.kind != StageKind::jump) return;
  if (counts()) counted_ += static_cast<double>(stage.cycles);
  friction_ = 1;
  levels_.clear(), aims_.clear(), rests_.clear();
}

void Jump::archive(io::Archive& a) {
  a("counted", counted_, {"-", "cycles since jump.from, jumps included; below 0: none count yet"});
  a("in_stage", in_stage_, {"-", "complete cycles of the present stage"});
  a("noted", noted_, {"-", "cycles counted when the levels were noted; below 0: they were not"});
  a("friction", friction_, {"-", "in a jump, friction over that of the contact laws"});
  a("noted_levels", noted_levels_, {"m", "height of each sleeper then"});
  a("levels", levels_, {"m", "height of each sleeper at the begin of the jump"});
  a("aims", aims_, {"m", "settlement of each sleeper in a jump"});
  a("rests", rests_, {"-", "1: the sleeper has settled so and is loaded no more in the jump"});
}

}  // namespace trackbed::model
