// With S(N) the law of settlement, m measured cycles before cycle N and J cycles in the jump, the
// sleepers should settle, in the mean, by
//   (S(N + J) - S(N))/(S(N) - S(N - m))
// times their settlement in the measured cycles. They do so in cycles of the same load in which the
// friction of all contacts falls from one to the next until they have: contacts that slide a little
// in each cycle slide at once. The state of the bed at the end is one of stones in contact, with a
// density that belongs to the settlement. What was rejected: docs/decisions/cycle_jump.md.
#include "model/stages/jump.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace trackbed::model {

namespace {

constexpr double friction_per_cycle = 0.97;  // of that in the cycle before
// Of the settlement that is to be reached: what may lack, and what more is warned of.
constexpr double near_enough = 0.05, too_far = 0.2;

}  // namespace

double Jump::level() const {
  double sum = 0;
  const std::size_t count = world_.sleepers->count();
  for (std::size_t i = 0; i < count; ++i) sum += world_.sleepers->state(i).displacement.z();
  return sum / static_cast<double>(count);
}

void Jump::note_level_before_jump(const Stage& stage) {
  const auto next = static_cast<std::size_t>(&stage - model_.stages.data()) + 1;
  if (next == model_.stages.size() || model_.stages[next].kind != StageKind::jump) return;
  if (in_stage_ != static_cast<double>(cycles_of(stage) - model_.jump.cycles)) return;
  level_ = level(), noted_ = counted_;
}

// If the mean has not fallen in the measured cycles, it need not in the jump.
std::string Jump::begin(const Stage& stage) {
  in_stage_ = 0;
  if (model_.counts_from() == &stage) counted_ = 0;
  if (stage.kind != StageKind::jump) {
    note_level_before_jump(stage);
    return {};
  }
  const double now = level(), settled = std::max(0.0, level_ - now);
  const auto law = [&](double cycles) { return settlement_law(cycles, model_.jump.exponent); };
  const double to = counted_ + static_cast<double>(stage.cycles);
  const double factor = noted_ < 0 ? 0 : (law(to) - law(counted_)) / (law(counted_) - law(noted_));
  level_ = now, aim_ = factor * settled, friction_ = 1;
  if (noted_ < 0) return "  no cycles have been measured: sleepers need not settle";
  return fmt::format(
      "  jump from cycle {:.0f} to {:.0f}: the sleepers should settle by {:.3g} mm in the mean, "
      "{:.4g} times as much as in the last {:.0f} cycles",
      counted_, to, 1e3 * aim_, factor, counted_ - noted_);
}

void Jump::end_cycle(const Stage& stage) {
  if (counts()) ++counted_;
  ++in_stage_;
  note_level_before_jump(stage);
}

double Jump::missing() const {
  const double left = aim_ - settled();
  return aim_ > 0 && left > near_enough * aim_ ? left : 0;
}

bool Jump::ends_cycle(const Clock& clock) const {
  const auto cycles_at = [&](std::int64_t window) {
    return std::floor(static_cast<double>(window) * clock.dt() / model_.jump.period);
  };
  return clock.window() > 0 && cycles_at(clock.window()) != cycles_at(clock.window() - 1);
}

void Jump::watch(const Stage& stage, const Clock& clock) {
  if (stage.kind != StageKind::jump || !ends_cycle(clock) || missing() == 0) return;
  friction_ = std::max(model_.jump.least_friction, friction_per_cycle * friction_);
  world_.particles.scale_friction(friction_);
}

double Jump::load(const Stage& stage, double time) const {
  if (stage.kind != StageKind::jump) return 0;
  const double phase = 2 * std::numbers::pi * time / model_.jump.period;
  return stage.load * 0.5 * (1 - std::cos(phase));
}

bool Jump::is_over(const Stage& stage, const Clock& clock) const {
  if (stage.kind != StageKind::jump) return false;
  return aim_ == 0 || (ends_cycle(clock) && missing() == 0);
}

std::string Jump::shortfall() const {
  if (noted_ < 0)
    return "no cycles have been measured before it: give a stage of cycles (jump.from)";
  if (missing() > 0)
    return fmt::format(
        "the sleepers should settle by {:.3g} mm in the mean and lack {:.3g} mm, with {:.3g} times "
        "the friction; give a longer stage.duration or a smaller jump.least_friction",
        1e3 * aim_, 1e3 * missing(), friction_);
  if (settled() <= (1 + too_far) * aim_ || aim_ == 0) return {};
  return fmt::format(
      "the sleepers should settle by {:.3g} mm in the mean and have settled by {:.3g} mm: single "
      "ones have sunk; give shorter jumps",
      1e3 * aim_, 1e3 * settled());
}

// A passage without `cycles` is one train.
void Jump::end(const Stage& stage) {
  if (stage.kind == StageKind::passage && stage.cycles == 0) end_cycle(stage);
  if (stage.kind != StageKind::jump) return;
  if (counts()) counted_ += static_cast<double>(stage.cycles);
  noted_ = -1, level_ = 0, aim_ = 0, friction_ = 1;
}

void Jump::archive(io::Archive& a) {
  a("counted", counted_, {"-", "cycles since jump.from, jumps included; below 0: none count yet"});
  a("in_stage", in_stage_, {"-", "complete cycles of the present stage"});
  a("noted", noted_, {"-", "cycles counted when the level was noted; below 0: it was not"});
  a("level", level_, {"m", "mean height of the sleepers then, in a jump at its begin"});
  a("aim", aim_, {"m", "mean settlement of a jump"});
  a("friction", friction_, {"-", "in a jump, friction over that of the contact laws"});
}

}  // namespace trackbed::model
