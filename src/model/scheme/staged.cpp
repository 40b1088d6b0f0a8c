// A run in stages. `advance` is one window of the coupled step.
#include "model/scheme/staged.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/scene/steps.hpp"
#include "model/scheme/placed_words.hpp"
#include "model/scheme/staged_log.hpp"
#include "model/scheme/warnings.hpp"
#include "model/stages/shear.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::model {

StagedScheme::StagedScheme(RunContext& run, const std::vector<bed::PlacedShape>& shapes)
    : run_(run),
      comm_(run.comm),
      model_(run.model),
      world_(comm_, model_),
      actions_(world_, model_),
      results_(comm_, run.folder + "/results.h5",
               {.deck = effective_deck(model_),
                .version = version(),
                .build = build_description(),
                .grading =
                    model_.has_one_grading() ? model_.bed.grading_table() : std::vector<double>{}}),
      sensors_(comm_, model_.sensors, model_.dem.gravity) {
  if (world_.placement) world_.placement->give_shapes(shapes);
  world_.particles.time_with(run_.timers);
  if (!world_.ground) return;
  world_.ground->time_with(run_.timers);
  sensors_.locate(*world_.ground);
}

double StagedScheme::begin_of_window() const {
  return static_cast<double>(run_.course.clock.window()) * run_.course.clock.dt();
}

double StagedScheme::middle_of_window() const {
  return (static_cast<double>(run_.course.clock.window()) + 0.5) * run_.course.clock.dt();
}

double StagedScheme::end_of_window() const {
  return (static_cast<double>(run_.course.clock.window()) + 1) * run_.course.clock.dt();
}

// One time window [t, t + dt] of the serial staggered scheme: bodies and ground move under the
// stones' mean forces of the last window, then the stones move with the surfaces, which have linear
// motion. Not iterated: each iteration would cost a whole window of stones; the error from the
// delay of the load is bounded by coupling_limit. (Serial staggered scheme: Felippa, Park, Farhat
// 2001, doi:10.1016/S0045-7825(00)00391-1.) The order is track, ground, stones; within a window the
// first two depend only on the stones' mean forces and not on each other, so their order does not
// matter.
void StagedScheme::advance() {
  const double dt = run_.course.clock.dt();
  move_sleepers(dt);
  move_platen(dt);
  move_walls(world_, run_.course.stage, begin_of_window(), dt);
  if (world_.placement) world_.placement->update(run_.course.clock.time(), dt);
  move_ground(dt);
  move_stones(dt);
  if (world_.placement)
    world_.placement->watch(world_.particles, world_.forces_on(SurfaceId::Part::placed), dt);
  average_support(dt);
  run_.course.tick();
  actions_.watch(present(), run_.course.clock);
}

// Loads are taken at mid-window: of second order in the window for a smooth load. Those of a train
// are taken at its start, from which leapfrog kicks; the rail then moves with the new positions of
// the sleepers. The stones' reaction is the mean of the last window, N: of first order in the
// window, which leads to the coupling limit. Local: every rank moves all sleepers identically.
void StagedScheme::move_sleepers(double dt) {
  if (!world_.sleepers || !world_.sleepers->placed()) return;
  const auto timing = run_.timers.scope(Phase::track);
  if (world_.solids) return move_solids(dt);
  seat_force_ = actions_.seat_forces(present(), middle_of_window());
  if (world_.tines) return tamp(world_, begin_of_window(), dt);
  world_.sleepers->advance(dt, actions_.on_seats(present(), middle_of_window(), seat_force_),
                           world_.nodal_forces_on(SurfaceId::Part::sleeper), model_.dem.gravity);
  actions_.move_train(present(), run_.course.clock);
}

// An implicit step uses the loads at its end. Axles run on solid rails, if there are any, and seat
// forces are known after the step; the same holds for a train, whose rail takes the same step.
void StagedScheme::move_solids(double dt) {
  world_.solids->roll(actions_.axles(present(), end_of_window()));
  world_.solids->advance(dt, actions_.seat_forces(present(), end_of_window()),
                         world_.nodal_forces_on(SurfaceId::Part::sleeper), model_.dem.gravity);
  actions_.move_train(present(), run_.course.clock);
  seat_force_ = world_.solids->seat_forces();
}

// In compact and shear stages the servo controls the platen, in release and triaxial stages its
// motion is given and its pressure only measured.
void StagedScheme::move_platen(double dt) {
  if (!world_.platen) return;
  world_.platen->set_area(world_.walls.area());
  if (present().kind == StageKind::release) {
    world_.platen->drive(dt, -present().lift * dt, world_.force_on({SurfaceId::Part::platen}).z());
    return;
  }
  if (present().kind == StageKind::triaxial)
    return drive_platen(world_, present(), begin_of_window(), dt);
  aim_platen(world_, run_.course.stage, begin_of_window(), dt);
  world_.platen->advance(dt, world_.force_on({SurfaceId::Part::platen}).z());
}

// A fixed ground keeps its shape, and the load of the bed on it is still averaged. Nodes are at
// their position at the start of the window plus their displacement in it: the first window of a
// fixed ground completes the last displacement.
void StagedScheme::move_ground(double dt) {
  if (!world_.ground) return;
  const auto timing = run_.timers.scope(Phase::ground);
  if (present().ground_moves) {
    if (world_.pressures) return load_ground(dt);
    world_.ground->advance(dt, world_.nodal_force_on({SurfaceId::Part::ground}));
    return;
  }
  Surface& top = world_.ground->top();
  for (const std::int32_t own : world_.ground->own_top()) {
    const auto node = static_cast<std::size_t>(own);
    top.position[node] += top.motion[node];
    top.motion[node].setZero();
  }
}

// A ground alone is loaded only by pressures, each step by those at its start and at its end.
void StagedScheme::load_ground(double dt) {
  const double begin = run_.course.clock.time();
  const auto load_at = [&](double time) {
    load_.assign(world_.ground->top().nodes(), Vec3::Zero());
    world_.pressures->add(time, load_);
    return std::span<const Vec3>(load_);
  };
  if (run_.course.windows == 0) world_.ground->initialise_acceleration(load_at(0));
  world_.ground->advance(dt, [&](double since) { return load_at(begin + since); });
}

// Scopes are narrow so that waiting for surfaces counts as coupling and not as dem. The stones' own
// sums of force, moment and work on surfaces are passed to the coupler, which compares both sides
// (docs/glossary.md, balance).
void StagedScheme::move_stones(double dt) {
  {
    const auto timing = run_.timers.scope(Phase::coupling);
    world_.coupler.publish();
  }
  {
    const auto timing = run_.timers.scope(Phase::dem);
    actions_.grow(present(), begin_of_window(), dt);
    world_.particles.advance(dt, run_.course.steps.substeps);
  }
  const auto timing = run_.timers.scope(Phase::coupling);
  world_.collect_loads(dt, run_.course.steps.substeps);
}

// Exponential mean, which costs one number per node and needs no history:
//   s += (dt/T) (f - s),   T = settle_average, s
// with f the force of this window, N. If the window is longer than T, s is the last force. Only own
// nodes: forces are valid there.
void StagedScheme::average_support(double dt) {
  if (!world_.ground || world_.ground_settled) return;
  const auto timing = run_.timers.scope(Phase::coupling);
  const double weight = model_.settle_average > dt ? dt / model_.settle_average : 1;
  const auto force = world_.nodal_force_on({SurfaceId::Part::ground});
  for (const std::int32_t own : world_.ground->own_top()) {
    const auto node = static_cast<std::size_t>(own);
    world_.support[node] += weight * (force[node] - world_.support[node]);
  }
}

void StagedScheme::start() {
  say_model(world_, run_.name);
  observe::Recorded recorded{.nodes = world_.watched,
                             .regions = model_.regions,
                             .sensors = model_.sensors,
                             .parts = model_.output.histories};
  // Present or future positions of sleepers: their number is the width of their histories.
  for (std::size_t i = 0; world_.sleepers && i < world_.sleepers->count(); ++i)
    recorded.sleeper_x.push_back(world_.sleepers->x(i));
  for (const Stage& stage : model_.stages) recorded.stages.push_back(stage.name);
  results_.begin(world_.scene(), recorded);
}

double StagedScheme::duration_of_later_stages() const {
  double time = 0;
  for (std::size_t i = run_.course.stage + 1; i < model_.stages.size(); ++i)
    time += actions_.duration(model_.stages[i]);
  return time;
}

Status StagedScheme::status() { return status_of(world_); }

std::vector<std::string> StagedScheme::warnings_at_end() {
  std::vector<std::string> warnings = warnings_of_end(world_, present().kind);
  if (const std::string steps = warning_of_steps(model_, run_.course.done); !steps.empty())
    warnings.push_back(steps);
  if (model_.has_train())
    for (const std::string& ends : actions_.train().rail_ends().warnings(
             model_.track.line, static_cast<std::size_t>(model_.seat.before),
             static_cast<std::size_t>(model_.sleepers.count)))
      warnings.push_back(ends);
  return warnings;
}

// Envelopes are those of the last passage: earlier passages serve for initial settlement.
bool StagedScheme::is_last_passage() const {
  if (present().kind != StageKind::passage) return false;
  for (std::size_t later = run_.course.stage + 1; later < model_.stages.size(); ++later)
    if (model_.stages[later].kind == StageKind::passage) return false;
  return true;
}

// The clock of a stage counts its windows from 0, so that stages with different windows follow each
// other without rounding. Steps are chosen after the stage's own stones and bodies have been added,
// which limit them.
bool StagedScheme::begin_stage() {
  const double time = run_.course.clock.time();
  if (!settle_ground()) return false;
  const std::string did = actions_.begin(present());
  const bool usual =
      model_.has_stage(StageKind::passage) ? is_last_passage() : run_.course.stage + 1 == stages();
  for (const std::string& warning : sensors_.begin_stage(present().name, usual, world_.particles))
    run_.warn(warning);
  if (run_.course.done.empty())
    for (const std::string& warning : warnings_of_bonds(world_, run_.course.stage))
      run_.warn(warning);
  begin_extremes();
  run_.course.steps = choose_steps(world_, step_of(world_), present(), run_.deck);
  if (present().kind == StageKind::fill && !model_.bed.cell.empty())
    world_.expect_weight(run_.course.steps.substeps);
  const double duration = actions_.duration(present());
  run_.course.clock =
      Clock(run_.course.steps.window, steps_covering(duration, run_.course.steps.window));
  run_.course.clock.set(time, 0);
  actions_.send_train(present(), run_.course.steps.window);
  seat_force_ = actions_.seat_forces(present(), 0);
  measured_ = measure_from(present().name, run_.timers, world_);
  stage_begin_ = run_.log.wall_time();
  say_stage_begins(run_, world_, present());
  if (!did.empty()) say(comm_, did);
  return true;
}

// Computes static equilibrium of the ground under the averaged load of the bed, so that it has no
// transient when it starts to move. For layers that yield this may take long: progress is logged,
// and the run can be stopped. Collective.
bool StagedScheme::settle_ground() {
  if (!present().ground_moves || !world_.ground || world_.ground_settled) return true;
  const auto timing = run_.timers.scope(Phase::ground);
  if (world_.pressures) world_.pressures->add_dead(world_.support);
  const auto waiting = say_equilibrium(world_);
  const auto report = [this](int iterations, double residual) {
    if (comm_.root() && run_.log.due())
      run_.log.instead(
          fmt::format("  static equilibrium of the ground: relative out-of-balance "
                      "force {:.2g} after {} iterations",
                      residual, iterations));
    return comm_.max(std::int64_t{run_.is_to_stop()}) == 0;
  };
  world_.ground_settled = world_.ground->settle(world_.support, report);
  return world_.ground_settled;
}

// `actions_.end` may remove stones (cribs), so results of the stage itself are written before it.
void StagedScheme::end_stage() {
  // A new partition after the last window, or a resume between it and this, leave no lists.
  if (model_.has_stones()) world_.particles.make_lists();
  {
    const auto timing = run_.timers.scope(Phase::output);
    if (model_.has_stones())
      results_.snapshot(present().name, world_.scene(),
                        model_.has_bed() ? model_.output.surface_cell : 0);
    results_.flush();
    if (is_last_passage()) results_.envelope(static_cast<std::int64_t>(run_.course.stage));
    if (model_.output.has_fields(present())) {
      if (keeps_extremes()) world_.ground->take_extremes();  // the last window may have no row
      write_fields_of_window();
    }
  }
  StageRecord record = record_of(present(), run_.course, world_);
  record.wall_time = run_.log.wall_time() - stage_begin_;
  record.settlement = actions_.settlement();
  if (model_.has_stones()) record.stable_step = world_.particles.stable_step(record.step());
  const std::optional<std::string> shortfall = actions_.shortfall(present());
  if (shortfall) record.set(shortfall->empty() ? Aim::reached : Aim::missed);
  run_.course.done.push_back(record);
  say_stage_ends(comm_, record);
  judge(record, shortfall.value_or(""));
  actions_.end(present());
}

// If a stage ends without reaching its aim, or the bed differs from the expected one, the run
// continues with a warning: the user must judge the bed, and has the checkpoint of the stage.
void StagedScheme::judge(const StageRecord& record, const std::string& shortfall) {
  if (!shortfall.empty())
    run_.warn(fmt::format("stage {} ended after {:.4g} s without reaching its aim: {}", record.name,
                          record.duration, shortfall));
  if (const std::size_t next = run_.course.stage + 1; next < stages()) {
    const std::string warning = warning_of_stiffening(world_, present(), model_.stages[next]);
    if (!warning.empty()) run_.warn(warning);
  }
  if (present().kind != StageKind::compact) return;
  const std::span<const Stage> done = std::span(model_.stages).first(run_.course.stage + 1);
  if (const std::string warning = warning_of_bed(world_, done); !warning.empty())
    run_.warn(fmt::format("stage {}: {}", record.name, warning));
}

// All ranks see that loads on surfaces are not balanced. The cause may be a stone on one rank whose
// position is not a number, which is otherwise found when the next lists are made: it comes first.
std::string StagedScheme::problem() {
  const std::string unbalanced = world_.coupler.trouble();
  std::string problem = world_.particles.trouble();
  if (!unbalanced.empty() && problem.empty()) problem = world_.particles.not_a_number();
  if (!unbalanced.empty()) problem = comm_.first_problem(problem);
  if (world_.placement && !problem.empty()) problem = by_names(problem, world_);
  if (problem.empty() && world_.ground) problem = world_.ground->trouble();
  if (problem.empty() && world_.sleepers) problem = world_.sleepers->trouble();
  return problem.empty() ? unbalanced : problem;
}

}  // namespace trackbed::model
