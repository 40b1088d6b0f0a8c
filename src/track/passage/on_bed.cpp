// The sleepers of the bed are integrated explicitly, rail, vehicles and all sleepers on springs
// implicitly. Forces are exchanged at common times (docs/decisions/train_on_bed.md):
//   F_n = k (w_n - u_n) + c (w'_n - u'_n)        N, on rail and sleeper, at t_n
//   the caller moves the sleepers under F_n to t_n+1, then `advance` moves the rail with w, w' at
//   t_n+1.
// w, w' are height (m) and velocity (m/s) of a sleeper since the rail was placed, u, u' those of
// the rail above it. Second order in the step, as Newmark and leapfrog are, and stable as long as
// the sleepers' step is (Belytschko, Mullen 1978, doi:10.1002/nme.1620121008). Rejected: including
// these sleepers in the rail's solve; they have six degrees of freedom, and the reaction of the
// stones is delayed by half a window in any case.
//
// Sleepers with an implicit step need the force at its end. They are linear: with w*, w'* of the
// seats without that force, Y = `mobility` (m/s per N, of a seat) and h the step (s),
//   w' = w'* - Y r F,  w = w* - h/2 Y r F,   F = f [k (w* - u) + c (w'* - u')],
//   f = 1/(1/z + r Y (c + k h/2)),   r rails of a seat, z the zones' factor of the pad,
// which is a softer pad on w*, w'*. Rail, pads and sleepers thus have one common implicit step
// without a delay of forces.
//
// With two rails there are two seats on every sleeper; w is then that of the seat, which the caller
// computes including the roll of the sleeper. The force at one seat also moves the other one: F, w
// are then pairs, Y and f symmetric 2 x 2 matrices, and the off-diagonal term of f couples the
// pads.
#include "trackbed/track/on_bed.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

double rails_of_seat(const TrainOnBedParameters& p) {
  return p.line.track.dimension == Dimension::space ? p.seat.rails / 2 : p.seat.rails;
}

LineParameters on_moved_sleepers(const TrainOnBedParameters& p) {
  LineParameters line = p.line;
  line.first_moved = static_cast<std::size_t>(p.seat.before);
  line.moved = p.sleepers;
  const PadParameters& pad = p.line.pad;
  const double follows = rails_of_seat(p) * (pad.damping + pad.stiffness * p.step / 2);
  for (std::size_t i = 0; i < p.mobility.size(); ++i) {
    Matrix2 softer = follows * p.mobility[i];
    const double x = p.line.track.sleeper_x(line.first_moved + i);
    for (const std::size_t side : {0, 1}) {
      const auto own = static_cast<Eigen::Index>(side);
      softer(own, own) += 1 / p.line.track.factor(&TrackZone::pad, x, side);
    }
    line.moved_pads.emplace_back(softer.inverse());
  }
  return line;
}

// m, heights of the seats at which the pads carry no load: above hanging sleepers the rail is laid
// higher than they lie.
std::vector<double> without_load(std::vector<double> levels, const std::vector<double>& gaps) {
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] += gaps[i];
  return levels;
}

// m, of each seat.
std::vector<double> gaps_of(const TrainOnBedParameters& p, std::size_t seats) {
  const TrackParameters& track = p.line.track;
  const std::size_t sides = seats / p.sleepers;
  std::vector<double> gaps;
  for (std::size_t i = 0; i < seats; ++i)
    gaps.push_back(
        track.gap(track.sleeper_x(static_cast<std::size_t>(p.seat.before) + i / sides), i % sides));
  return gaps;
}

}  // namespace

// The order of the members matters: the passage keeps references to line and train.
struct TrainOnBed::Impl {
  Impl(const TrainOnBedParameters& p, const std::vector<double>& at)
      : begin(p.first - p.line.track.sleeper_x(static_cast<std::size_t>(p.seat.before))),
        gaps(gaps_of(p, at.size())),
        levels(without_load(at, gaps)),
        target(p.kept.empty() ? levels : p.kept),
        ramp(p.kept.empty() ? 0 : std::max<std::int64_t>(1, std::llround(p.ramp / p.step))),
        line(on_moved_sleepers(p)),
        rails(rails_of_seat(p)),
        step(p.step),
        mobility(p.mobility),
        train(p.train, p.vehicles, p.line.track.rails, p.line.track.wheel_gauge()),
        passage(line, train, WheelRail(p.wheel_rail),
                Irregularity(p.irregularity, p.line.track.length), p.train,
                {.step = p.step, .duration = 0, .tolerance = p.tolerance}, right_of(p)) {
    require(at.size() == line.seats() && target.size() == at.size() &&
                (p.mobility.empty() || p.mobility.size() == p.sleepers),
            "one level for each seat of the bed");
  }

  // Fraction of the difference between the levels at the start and those of the kept rail that is
  // left after these steps; ends are smooth.
  double left_after(std::int64_t steps) const {
    const double done = static_cast<double>(steps) / static_cast<double>(ramp);
    return (1 + std::cos(std::numbers::pi * done)) / 2;
  }

  // The pads of a kept rail take up their forces gradually: the sleepers, which had no rail, are
  // not in equilibrium with it. To the end of the next step.
  void approach_kept_rail(std::vector<Seat>& seats) {
    if (ramped >= ramp) return;
    const double ratio = ramped + 1 == ramp ? 0 : left_after(ramped + 1) / left_after(ramped);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const double before = levels[i];
      levels[i] = target[i] + (levels[i] - target[i]) * ratio;
      seats[i].height -= levels[i] - before;
      seats[i].rate -= (levels[i] - before) / step;
    }
    ++ramped;
  }

  static std::optional<Irregularity> right_of(const TrainOnBedParameters& p) {
    if (!p.irregularity_right) return {};
    return Irregularity(*p.irregularity_right, p.line.track.length);
  }

  double begin;              // m, x of the bed at the start of the track
  std::vector<double> gaps;  // m, of the seats
  // m, of the seats at which pads carry no load, now and after the ramp: state.
  std::vector<double> levels, target;
  std::int64_t ramp, ramped = 0;  // steps of the ramp, and those done: state
  Line line;
  double rails;  // number of rails per seat
  double step;   // s
  std::vector<Matrix2> mobility;
  Train train;
  Passage passage;
};

// Limits: a slice may be as thin as a stone, whole sleepers carry two rails.
void SeatParameters::declare(input::Section& s) {
  s.integer(
      "before", before, {.at_least = 0, .at_most = 10000},
      "Number of sleepers on springs ([ballast]) before the first sleeper of the bed; the rest of "
      "the track, up to track.length, lies beyond the last sleeper of the bed (larger x).");
  s.number(
      "rails", rails, {.above = 0, .at_most = 2},
      "Number of rails whose load the sleepers of the model carry: 1 for half a track; 2 for a "
      "whole track, whether track.dimension is plane or space; below 1 for a slice that carries "
      "this fraction of the load of one rail.");
}

TrainOnBed::TrainOnBed(const TrainOnBedParameters& parameters, const std::vector<double>& levels)
    : impl_(std::make_unique<Impl>(parameters, levels)) {}
TrainOnBed::~TrainOnBed() = default;
TrainOnBed::TrainOnBed(TrainOnBed&&) noexcept = default;

const Train& TrainOnBed::train() const { return impl_->train; }
const Line& TrainOnBed::line() const { return impl_->line; }
const Passage& TrainOnBed::passage() const { return impl_->passage; }
const std::vector<double>& TrainOnBed::levels_without_load() const { return impl_->target; }
void TrainOnBed::restart_train() { impl_->passage.restart_train(); }

double TrainOnBed::seat_force(std::size_t i) const {
  double sum = 0;
  for (std::size_t side = 0; side < impl_->line.sides(); ++side) sum += seat_force(i, side);
  return sum;
}

double TrainOnBed::seat_force(std::size_t i, std::size_t side) const {
  return impl_->rails * impl_->passage.seat_force(i, side);
}

double TrainOnBed::seat_displacement(std::size_t i, std::size_t side) const {
  const Impl& impl = *impl_;
  double height = impl.passage.seat(i, side).height;
  for (std::size_t by = 0; !impl.mobility.empty() && by < impl.line.sides(); ++by)
    height -= impl.step / 2 * seat_force(i, by) *
              impl.mobility[i](static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(by));
  return height;
}

void TrainOnBed::advance(const std::vector<double>& levels, const std::vector<double>& rates) {
  Impl& impl = *impl_;
  require(levels.size() == impl.levels.size() && rates.size() == levels.size(),
          "level and rate of each seat of the bed");
  std::vector<Seat> seats(levels.size());
  for (std::size_t i = 0; i < seats.size(); ++i)
    seats[i] = {.height = levels[i] - impl.levels[i], .rate = rates[i]};
  impl.approach_kept_rail(seats);
  impl.passage.place_seats(seats);
  impl.passage.advance();
}

double TrainOnBed::highest_seat() const {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < impl_->gaps.size(); ++i)
    highest = std::max(highest, impl_->target[i] - impl_->gaps[i]);
  return highest;
}

double TrainOnBed::origin() const { return impl_->begin; }
double TrainOnBed::wheel_x(std::size_t i) const { return impl_->begin + impl_->passage.wheel_x(i); }

double TrainOnBed::rail_displacement(std::size_t i, std::size_t side) const {
  return impl_->passage.rail_displacement(impl_->line.sleeper_x(impl_->line.first_moved() + i),
                                          side);
}

void TrainOnBed::archive(io::Archive& a) {
  impl_->passage.archive(a);
  a.rows("levels", impl_->levels,
         {"m", "heights of the rail seats at which the pads carry no load now"});
  a.rows("kept_levels", impl_->target, {"m", "the same when a kept rail carries its pads' forces"});
  a("ramp_steps", impl_->ramp,
    {"-", "steps in which a kept rail takes up these forces; 0: a laid rail"});
  a("ramped_steps", impl_->ramped, {"-", "those done"});
}

}  // namespace trackbed::track
