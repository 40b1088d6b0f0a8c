// Output during a run in stages: history rows, fields, extremes. Nothing of it changes a result.
#include <fmt/format.h>

#include "model/scheme/staged.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::model {

namespace {

// The check is a reduction, and work moves between ranks only as stones do.
constexpr std::int64_t windows_between_partitions = 100;

}  // namespace

// Rows and fields; a new partition of the stones, which leaves results bitwise identical.
void StagedScheme::record() {
  // The first row of a stage, to which envelopes and figures are relative, is that of its first
  // window: before it bodies have been added or removed, and contacts are not known yet. The others
  // follow at equal intervals, as spectra need them.
  // In models of placed stones the last window has a row, too, since the end of such an experiment
  // is its result. Here and not in `end_stage`, where a resumed run may have no contacts yet.
  const bool due =
      (run_.course.clock.window() - 1) % run_.windows_in(model_.output.history_interval) == 0;
  const bool row = due || (model_.is_placed() && !(run_.course.clock.runs() && !is_done()));
  const bool picture =
      model_.output.has_fields(present()) && run_.ends(model_.output.fields_interval);
  if (row) sample();
  if ((row || picture) && keeps_extremes()) world_.ground->take_extremes();
  if (picture) {
    const auto timing = run_.timers.scope(Phase::output);
    write_fields_of_window();
  }
  if (run_.course.windows % windows_between_partitions != 0) return;
  // Not after the last window: a new partition has no contacts, which the end of a stage writes.
  if (!run_.course.clock.runs() || is_done()) return;
  const auto timing = run_.timers.scope(Phase::partition);
  world_.rebalance();
}

void StagedScheme::write_fields_of_window() {
  write_fields(fmt::format("{}_{:06d}", present().name, run_.course.clock.window()),
               model_.output.fields_parts);
}

// Histories, and all fields as they are after the window with the error, whatever the deck writes.
std::string StagedScheme::rescue() noexcept {
  try {
    results_.flush();
    const std::string name =
        fmt::format("failed_{}_{:06d}", present().name, run_.course.clock.window());
    if (model_.has_stones()) world_.particles.make_lists();
    write_fields(name, {observe::field_parts.begin(), observe::field_parts.end()});
    return fmt::format("its state then is in {}/fields/{}_*.hdf", run_.folder, name);
  } catch (const std::exception&) {  // for example a full disk; the first error is reported
    return {};
  }
}

void StagedScheme::write_fields(const std::string& name, const std::vector<std::string>& parts) {
  const observe::TrainInstant train = actions_.train().instant();
  std::optional<observe::TrainView> view;
  if (train.running)
    view.emplace(observe::TrainView{
        *train.running, train.rails, model_.track.wheel_rail.bodies.wheel_radius,
        world_.sleepers->bottom() + model_.sleepers.height, model_.sleepers.gauge});
  observe::write_fields(comm_, run_.field_files(name, parts), world_.scene(),
                        view ? &*view : nullptr);
}

// A fixed ground has no extremes.
bool StagedScheme::keeps_extremes() const {
  return model_.output.ground_extremes && present().ground_moves && world_.ground;
}

// Extremes are those of the present stage only.
void StagedScheme::begin_extremes() {
  if (keeps_extremes())
    world_.ground->begin_extremes();
  else if (world_.ground)
    world_.ground->end_extremes();
}

// When a run is resumed within a stage; `kept`: whether the checkpoint has extremes.
void StagedScheme::resume_extremes(bool kept) {
  if (world_.ground && !keeps_extremes()) world_.ground->end_extremes();
  if (keeps_extremes() && !kept)
    run_.warn(
        fmt::format("output.ground_extremes: extremes of stage \"{}\" include only times from "
                    "{:.6g} s on, where the run was resumed; they were not recorded before",
                    present().name, run_.course.clock.time()));
}

// The seat force of a row is the one that moved the sleepers in the window before it. Collective.
void StagedScheme::sample() {
  const auto timing = run_.timers.scope(Phase::observe);
  const std::vector<observe::WallState> walls = world_.wall_states();
  const observe::PlatenState platen = world_.platen_state();
  const observe::TrainInstant train = actions_.train().instant();
  const observe::SolidState solids =
      world_.solids ? world_.solids->observed() : observe::SolidState{};
  const observe::PlacedInstant placed =
      world_.placement ? world_.placement->instant(world_.particles, run_.course.clock.time())
                       : observe::PlacedInstant{};
  const std::vector<observe::SensorReading> sensors =
      sensors_.empty()
          ? std::vector<observe::SensorReading>{}
          : sensors_.read(&world_.particles, world_.ground ? &*world_.ground : nullptr);
  results_.sample(world_.scene(), {.time = run_.course.clock.time(),
                                   .stage = static_cast<std::int64_t>(run_.course.stage),
                                   .seat_force = seat_force_,
                                   .walls = walls,
                                   .platen = model_.uses_platen() ? &platen : nullptr,
                                   .cycles = model_.counts_from() ? actions_.jump().cycles() : -1,
                                   .train = model_.has_train() ? &train : nullptr,
                                   .solids = world_.solids ? &solids : nullptr,
                                   .placed = world_.placement ? &placed : nullptr,
                                   .sensors = sensors});
}

void StagedScheme::finish() {
  if (!model_.output.compress) return;
  const auto timing = run_.timers.scope(Phase::output);
  const std::string failure = results_.compress();
  if (!failure.empty())
    run_.warn(
        fmt::format("results.h5 is complete, but it was not compressed: {}; h5repack can do this "
                    "later",
                    failure));
}

void StagedScheme::summarize(nlohmann::ordered_json& summary) {
  put_figures({.world = world_,
               .course = run_.course,
               .timers = run_.timers,
               .measured = measured_,
               .wheels = actions_.train().wheel_forces()},
              summary);
}

}  // namespace trackbed::model
