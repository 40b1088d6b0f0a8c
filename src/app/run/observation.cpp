// Output during a run: history rows, fields, periodic checkpoints, the summary. Nothing of it
// changes a result.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/run/simulation.hpp"
#include "app/run/summary.hpp"

namespace trackbed::app {

namespace {

// The check is a reduction, and work moves between ranks only as stones do.
constexpr std::int64_t windows_between_balance_checks = 100;

}  // namespace

// Collective.
void Simulation::write_summary(bool finished) {
  app::write_summary({.deck = name_,
                      .folder = folder_,
                      .world = world_,
                      .course = course_,
                      .regions = model_.regions,
                      .timers = timers_,
                      .measured = measured_,
                      .deck_warnings = deck_warnings_,
                      .wheels = actions_.train().wheel_forces(),
                      .wall_time = progress_.wall_time(),
                      .finished = finished});
}

// Whether the present window ends a multiple of `interval` s. Counted in whole windows of the
// stage, so that it needs no state and does not drift: a resumed run writes in the same windows.
bool Simulation::every(double interval) const {
  return interval > 0 && course_.clock.window() % windows_in(interval) == 0;
}

std::int64_t Simulation::windows_in(double interval) const {
  return std::max<std::int64_t>(1, std::llround(interval / course_.clock.dt()));
}

// Rows, fields, and the load balance over ranks; none of them changes a result. Collective. A new
// partition of the stones leaves results bitwise identical.
void Simulation::observe() {
  // The first row of a stage, to which envelopes and figures are relative, is that of its first
  // window: before it bodies have been added or removed, and contacts are not known yet. The others
  // follow at equal intervals, as spectra need them.
  // In models of placed stones the last window has a row, too, since the end of such an experiment
  // is its result. Here and not in `end_stage`, where a resumed run may have no contacts yet.
  const bool due = (course_.clock.window() - 1) % windows_in(model_.output.history_interval) == 0;
  const bool row = due || (model_.is_placed() && !runs());
  const bool picture = model_.output.fields && every(model_.output.fields_interval);
  if (row) sample();
  if ((row || picture) && keeps_extremes()) world_.ground->take_extremes();
  if (picture) {
    const auto timing = timers_.scope(Verb::output);
    observe::write_pictures(comm_, folder_ + "/fields",
                            fmt::format("{}_{:06d}", stage().name, course_.clock.window()),
                            world_.scene());
  }
  if (course_.windows % windows_between_balance_checks == 0) world_.rebalance();
}

// A fixed ground has no extremes.
bool Simulation::keeps_extremes() const {
  return model_.output.ground_extremes && stage().ground_moves && world_.ground;
}

// Extremes are those of the present stage only.
void Simulation::begin_extremes() {
  if (keeps_extremes())
    world_.ground->begin_extremes();
  else if (world_.ground)
    world_.ground->end_extremes();
}

// When a run is resumed within a stage; `kept`: whether the checkpoint has extremes.
void Simulation::resume_extremes(bool kept) {
  if (world_.ground && !keeps_extremes()) world_.ground->end_extremes();
  if (keeps_extremes() && !kept)
    warn(
        fmt::format("output.ground_extremes: extremes of stage \"{}\" are those from {:.6g} s on, "
                    "where the run was resumed: they were not recorded before",
                    stage().name, course_.clock.time()));
}

// The seat force of a row is the one that moved the sleepers in the window before it. Collective.
void Simulation::sample() {
  const auto timing = timers_.scope(Verb::observe);
  const std::vector<observe::WallState> walls = world_.wall_states();
  const observe::PlatenState platen = world_.platen_state();
  const observe::TrainInstant train = actions_.train().instant();
  const observe::SolidState solids =
      world_.solids ? world_.solids->observed() : observe::SolidState{};
  const observe::PlacedInstant placed =
      world_.placement ? world_.placement->instant(world_.particles, course_.clock.time())
                       : observe::PlacedInstant{};
  results_.sample(world_.scene(), {.time = course_.clock.time(),
                                   .stage = static_cast<std::int64_t>(course_.stage),
                                   .seat_force = seat_force_,
                                   .walls = walls,
                                   .platen = model_.uses_platen() ? &platen : nullptr,
                                   .train = model_.has_train() ? &train : nullptr,
                                   .solids = world_.solids ? &solids : nullptr,
                                   .placed = world_.placement ? &placed : nullptr});
}

// At most two periodic checkpoints are kept. Those of a run before it was resumed are not known
// here and remain.
void Simulation::checkpoint_if_due() {
  if (!every(model_.output.checkpoint_interval)) return;
  const std::string name = fmt::format("checkpoint_{:010d}.h5", course_.windows);
  checkpoint(name);
  // The one before is kept too: a disk that fills up while writing must not destroy both.
  periodic_checkpoints_.push_back(last_checkpoint_);
  if (periodic_checkpoints_.size() <= 2) return;
  std::error_code ignored;
  if (comm_.root()) std::filesystem::remove(periodic_checkpoints_.front(), ignored);
  periodic_checkpoints_.erase(periodic_checkpoints_.begin());
}

}  // namespace trackbed::app
