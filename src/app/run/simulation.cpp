// The run: a loop over stages, and in each a loop over windows. `window` advances one window,
// `run_stages` contains the loops; both must remain short. One agreement per window covers errors
// on any rank, signals, the wall-time limit and log lines, and costs one reduction.
//
// Errors of one rank are raised at this agreement: until then the rank continues, so that no rank
// waits in a collective call for one that has left.
#include "app/run/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/check/warnings.hpp"
#include "app/deck/deck_files.hpp"
#include "app/parameters/version.hpp"
#include "app/run/interrupt.hpp"
#include "app/run/placed_words.hpp"
#include "app/run/result_folder.hpp"
#include "app/run/summary.hpp"
#include "app/stages/shear.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

// Rounded up, so that a stage is never shorter than given; the margin keeps 0.3/0.1 at 3. At least
// one, so that every stage begins and ends.
std::int64_t whole_windows(double duration, double window) {
  return std::max<std::int64_t>(1, std::llround(std::ceil(duration / window * (1 - 1e-9))));
}

// The range of the exact sums of loads grows with the loads (Particles::expect_load), and the load
// of a poured bed grows slowly. The weight of a bed laid from copies acts at once, and its floor
// may have one node for a thousand stones. The range is eight times the expected load: the weight
// for copies, which may oscillate with twice their weight; a quarter of it for other beds, so that
// those with sufficient range remain bitwise identical. Collective.
void expect_weight(World& world, int substeps) {
  const double weight = world.particles.totals().mass * world.model.dem.gravity;
  const double part = world.model.bed.cell.empty() ? 0.25 : 1;
  world.particles.expect_load(part * weight * substeps);
}

}  // namespace

Simulation::Simulation(const par::Comm& comm, const Model& model, const input::Deck& deck,
                       const std::string& name, const std::string& folder)
    : comm_(comm),
      model_(model),
      deck_(deck),
      name_(name),
      folder_(folder),
      files_(contents_of_files(comm, effective_deck(model))),
      world_(comm, model),
      actions_(world_, model),
      results_(
          comm, folder + "/results.h5",
          {.deck = effective_deck(model),
           .version = version(),
           .grading = model.has_one_grading() ? model.bed.grading_table() : std::vector<double>{}}),
      progress_(comm) {
  world_.particles.time_with(timers_);
}

// One time window [t, t + dt] of the serial staggered scheme: bodies and ground move under the
// stones' mean forces of the last window, then the stones move with the surfaces, which have linear
// motion. Not iterated: each iteration would cost a whole window of stones; the error from the
// delay of the load is bounded by coupling_limit. (Serial staggered scheme: Felippa, Park, Farhat
// 2001, doi:10.1016/S0045-7825(00)00391-1.) The order is track, ground, stones; within a window the
// first two depend only on the stones' mean forces and not on each other, so their order does not
// matter.
void Simulation::window() {
  const double dt = course_.clock.dt();
  move_sleepers(dt);
  move_platen(dt);
  move_walls(world_, course_.stage, static_cast<double>(course_.clock.window()) * dt, dt);
  if (world_.placement) world_.placement->update(course_.clock.time(), dt);
  move_ground(dt);
  move_stones(dt);
  if (world_.placement) world_.placement->watch(world_.particles, world_.on_placed(), dt);
  average_support(dt);
}

// Loads are taken at mid-window: of second order in the window for a smooth load. Those of a train
// are taken at its start, from which leapfrog kicks; the rail then moves with the new positions of
// the sleepers. The stones' reaction is the mean of the last window, N: of first order in the
// window, which leads to the coupling limit. Local: every rank moves all sleepers identically.
void Simulation::move_sleepers(double dt) {
  if (!world_.sleepers || !world_.sleepers->placed()) return;
  const auto timing = timers_.scope(Verb::track);
  if (world_.solids) return move_solids(dt);
  const double mid_window = (static_cast<double>(course_.clock.window()) + 0.5) * dt;
  seat_force_ = actions_.seat_forces(stage(), mid_window);
  if (world_.tines) return tamp(world_, static_cast<double>(course_.clock.window()) * dt, dt);
  world_.sleepers->advance(dt, actions_.on_seats(stage(), mid_window, seat_force_),
                           world_.on_sleepers(), model_.dem.gravity);
  actions_.move_train(stage(), course_.clock);
}

// An implicit step uses the loads at its end. Axles run on solid rails, if there are any, and seat
// forces are known after the step; the same holds for a train, whose rail takes the same step.
void Simulation::move_solids(double dt) {
  const double end = (static_cast<double>(course_.clock.window()) + 1) * dt;
  world_.solids->roll(actions_.axles(stage(), end));
  world_.solids->advance(dt, actions_.seat_forces(stage(), end), world_.on_sleepers(),
                         model_.dem.gravity);
  actions_.move_train(stage(), course_.clock);
  seat_force_ = world_.solids->seat_forces();
}

// In compact and shear stages the servo controls the platen, in release and triaxial stages its
// motion is given. Release: the speed does not depend on the reaction of the bed, and in the first
// window there is no previous displacement to complete.
void Simulation::move_platen(double dt) {
  if (!world_.platen) return;
  const double time = static_cast<double>(course_.clock.window()) * dt;
  if (stage().kind == StageKind::release) {
    world_.lift_platen(course_.clock.window() > 0 ? stage().lift * dt : 0, stage().lift * dt);
    return;
  }
  world_.platen->set_area(world_.walls.area());
  if (stage().kind == StageKind::triaxial) return drive_platen(world_, stage(), time, dt);
  aim_platen(world_, course_.stage, time, dt);
  world_.platen->advance(dt, world_.on_platen());
}

// A fixed ground keeps its shape, and the load of the bed on it is still averaged. Nodes are at
// their position at the start of the window plus their displacement in it: the first window of a
// fixed ground completes the last displacement.
void Simulation::move_ground(double dt) {
  if (!world_.ground) return;
  const auto timing = timers_.scope(Verb::ground);
  if (stage().ground_moves) {
    if (world_.pressures) return load_ground(dt);
    world_.ground->advance(dt, world_.on_ground());
    return;
  }
  Surface& top = world_.ground->top();
  for (const std::int32_t own : world_.ground->own_top()) {
    const auto node = static_cast<std::size_t>(own);
    top.position[node] += top.motion[node];
    top.motion[node].setZero();
  }
}

// A ground alone is loaded only by pressures. Each step uses the loads at its start and at its end:
// a load that is constant in a window, like that of stones, would give velocities of the top with
// an error of first order.
void Simulation::load_ground(double dt) {
  const double begin = course_.clock.time();
  const auto load_at = [&](double time) {
    load_.assign(world_.ground->top().nodes(), Vec3::Zero());
    world_.pressures->add(time, load_);
    return std::span<const Vec3>(load_);
  };
  if (course_.windows == 0) world_.ground->initialise_acceleration(load_at(0));
  if (model_.ground.integrator != fem::Integrator::explicit_)
    return world_.ground->advance(dt, load_at(begin + dt));
  const auto steps = whole_windows(dt, world_.ground->stable_step());
  const double step = dt / static_cast<double>(steps);
  for (std::int64_t k = 1; k <= steps; ++k) {
    world_.ground->begin_step(step);
    world_.ground->end_step(load_at(begin + static_cast<double>(k) * step));
  }
}

// Scopes are narrow so that waiting for surfaces counts as coupling and not as dem. The stones' own
// sums of force, moment and work on surfaces are passed to the coupler, which compares both sides
// (docs/glossary.md, balance).
void Simulation::move_stones(double dt) {
  {
    const auto timing = timers_.scope(Verb::coupling);
    world_.coupler.publish();
  }
  {
    const auto timing = timers_.scope(Verb::dem);
    actions_.grow(stage(), static_cast<double>(course_.clock.window()) * dt, dt);
    world_.particles.advance(dt, course_.steps.substeps);
  }
  const auto timing = timers_.scope(Verb::coupling);
  const dem::SurfaceAction& did = world_.particles.surface_action();
  world_.coupler.collect(course_.steps.substeps, dt, {did.force, did.moment, did.work});
  world_.particles.expect_load(world_.coupler.largest_load());
}

// Exponential mean, which costs one number per node and needs no history:
//   s += (dt/T) (f - s),   T = settle_average, s
// with f the force of this window, N. If the window is longer than T, s is the last force. Only own
// nodes: forces are valid there.
void Simulation::average_support(double dt) {
  if (!world_.ground || world_.ground_settled) return;
  const auto timing = timers_.scope(Verb::coupling);
  const double weight = model_.settle_average > dt ? dt / model_.settle_average : 1;
  const auto force = world_.on_ground();
  for (const std::int32_t own : world_.ground->own_top()) {
    const auto node = static_cast<std::size_t>(own);
    world_.support[node] += weight * (force[node] - world_.support[node]);
  }
}

// Adds to error messages when and in which stage the error occurred, and the last checkpoint.
Outcome Simulation::run() {
  try {
    const Outcome outcome = run_stages();
    progress_.timer_table(timers_);
    return outcome;
  } catch (const RunError& error) {
    throw RunError(fmt::format("{} (at {:.6g} s, stage \"{}\"); {}", error.what(),
                               course_.clock.time(), stage().name,
                               what_is_left(last_checkpoint_, started_from_)));
  }
}

// A resumed run enters a stage that has begun, and so skips `begin_stage`; nothing else differs.
// Everything a stage does besides windows is in `begin_stage` and `end_stage`. The row of a window,
// its log line and its checkpoint come after the agreement: they are collective, and all ranks must
// take part.
Outcome Simulation::run_stages() {
  catch_interrupts();
  progress_.start(world_, model_, name_);
  // Present or future positions of sleepers: their number is the width of their histories.
  std::vector<double> sleeper_x;
  for (std::size_t i = 0; world_.sleepers && i < world_.sleepers->count(); ++i)
    sleeper_x.push_back(world_.sleepers->x(i));
  results_.begin(world_.scene(), world_.watched, sleeper_x, model_.regions);
  // A checkpoint is written after the window's row and agreement: a resumed run repeats neither.
  while (course_.stage < model_.stages.size()) {
    if (!course_.begun && !begin_stage()) {
      write_summary(false);
      return Outcome::stopped;
    }
    while (runs()) {
      window();
      course_.clock.tick(), ++course_.windows;
      actions_.watch(stage(), course_.clock);
      const Verdict verdict = agree();
      observe();
      if (verdict == Verdict::report) progress_.line(course_, model_, world_);
      if (verdict == Verdict::stop) {
        checkpoint(fmt::format("checkpoint_{:010d}.h5", course_.windows));
        write_summary(false);
        return Outcome::stopped;
      }
      checkpoint_if_due();
    }
    end_stage();
  }
  // After the loop the number is one beyond the last stage.
  course_.stage = model_.stages.size() - 1;
  for (const std::string& warning : warnings_of_end(world_, stage().kind)) warn(warning);
  write_summary(true);
  return Outcome::finished;
}

// Called again for the same window by a run that is resumed there: must depend on state alone.
// Collective, since `settled` is.
bool Simulation::runs() const {
  return course_.clock.runs() && !actions_.settled(stage(), course_.clock);
}

// Envelopes are those of the last passage: earlier passages serve for initial settlement.
bool Simulation::is_last_passage() const {
  if (stage().kind != StageKind::passage) return false;
  for (std::size_t later = course_.stage + 1; later < model_.stages.size(); ++later)
    if (model_.stages[later].kind == StageKind::passage) return false;
  return true;
}

// The clock of a stage counts its windows from 0, so that stages with different windows follow each
// other without rounding. Steps are chosen after the stage's own stones and bodies have been added,
// which limit them. False if the run is to stop, before any change that a checkpoint would need.
bool Simulation::begin_stage() {
  const double time = course_.clock.time();
  if (!settle_ground()) return false;
  actions_.begin(stage());
  begin_extremes();
  course_.steps = choose_steps(world_, step_of(world_), stage(), deck_);
  if (stage().kind == StageKind::fill && !model_.bed.cell.empty())
    expect_weight(world_, course_.steps.substeps);
  const double duration = actions_.duration(stage());
  course_.clock = Clock(course_.steps.window, whole_windows(duration, course_.steps.window));
  course_.clock.set(time, 0);
  course_.begun = true;
  actions_.send_train(stage(), course_.steps.window);
  seat_force_ = actions_.seat_forces(stage(), 0);
  measured_ = measure_from(stage().name, timers_, world_);
  stage_begin_ = progress_.wall_time();
  progress_.stage_begins(stage(), course_, world_);
  return true;
}

// Computes static equilibrium of the ground under the averaged load of the bed, so that it has no
// transient when it starts to move. For layers that yield this may take long: progress is logged,
// and the run can be stopped. Collective.
bool Simulation::settle_ground() {
  if (!stage().ground_moves || !world_.ground || world_.ground_settled) return true;
  const auto timing = timers_.scope(Verb::ground);
  if (world_.pressures) world_.pressures->add_dead(world_.support);
  const auto waiting = progress_.equilibrium(world_);
  const auto report = [this](int iterations, double residual) {
    if (comm_.root() && progress_.due()) progress_.static_iteration(iterations, residual);
    return comm_.max(std::int64_t{is_to_stop()}) == 0;
  };
  world_.ground_settled = world_.ground->settle(world_.support, report);
  return world_.ground_settled;
}

// The checkpoint comes last: it contains the state after the end of the stage, and a run resumed
// from it begins with the next stage. `actions_.end` may remove stones (cribs), so results of the
// stage itself are written before it.
void Simulation::end_stage() {
  {
    const auto timing = timers_.scope(Verb::output);
    if (model_.has_stones())
      results_.snapshot(stage().name, world_.scene(),
                        model_.has_bed() ? model_.output.surface_cell : 0);
    results_.flush();
    if (is_last_passage()) results_.envelope(static_cast<std::int64_t>(course_.stage));
    if (model_.output.fields) {
      if (keeps_extremes()) world_.ground->take_extremes();  // the last window may have no row
      observe::write_pictures(comm_, folder_ + "/fields",
                              fmt::format("{}_{:06d}", stage().name, course_.clock.window()),
                              world_.scene());
    }
  }
  StageRecord record = record_of(stage(), course_, model_, world_);
  record.wall_time = progress_.wall_time() - stage_begin_;
  record.settlement = actions_.settlement();
  const std::optional<std::string> shortfall = actions_.shortfall(stage());
  if (shortfall) record.aim = shortfall->empty() ? Aim::reached : Aim::missed;
  course_.done.push_back(record);
  progress_.stage_ends(record);
  judge(record, shortfall.value_or(""));
  actions_.end(stage());
  course_.begun = false;
  checkpoint("stage_" + stage().name + ".h5");
  ++course_.stage;
}

// If a stage ends without reaching its aim, or the bed differs from the expected one, the run
// continues with a warning: the user must judge the bed, and has the checkpoint of the stage.
void Simulation::judge(const StageRecord& record, const std::string& shortfall) {
  if (!shortfall.empty())
    warn(fmt::format("stage {} ended after {:.4g} s without reaching its aim: {}", record.name,
                     record.duration, shortfall));
  if (stage().kind != StageKind::compact) return;
  const std::span<const Stage> done = std::span(model_.stages).first(course_.stage + 1);
  if (const std::string warning = warning_of_bed(world_, done); !warning.empty())
    warn(fmt::format("stage {}: {}", record.name, warning));
}

// Printed at once, and repeated in summary.json. Local, but the same on all ranks.
void Simulation::warn(const std::string& sentence) {
  course_.warnings.push_back(sentence);
  progress_.warning(sentence);
}

// Signals may reach any rank; wall time is that of rank 0 alone, since clocks of nodes differ.
bool Simulation::is_to_stop() const {
  const bool out_of_time = comm_.root() && model_.output.wall_time > 0 &&
                           progress_.wall_time() > model_.output.wall_time;
  return interrupted() || out_of_time;
}

// The one agreement of a window: an error on any rank, a request to stop, a log line that is due.
Simulation::Verdict Simulation::agree() {
  std::string problem = world_.particles.trouble();
  if (world_.placement && !problem.empty()) problem = by_names(problem, world_);
  if (problem.empty() && world_.ground) problem = world_.ground->trouble();
  if (problem.empty() && world_.sleepers) problem = world_.sleepers->trouble();
  if (problem.empty()) problem = world_.coupler.trouble();
  // Ordered by priority, so that the maximum over ranks decides: errors before all others.
  Verdict mine = Verdict::go_on;
  if (comm_.root() && progress_.due()) mine = Verdict::report;
  const bool far_enough =
      model_.output.stop_after > 0 && course_.windows == model_.output.stop_after;
  if (is_to_stop() || far_enough) mine = Verdict::stop;
  if (!problem.empty()) mine = Verdict::trouble;
  const auto verdict = static_cast<Verdict>(comm_.max(static_cast<std::int64_t>(mine)));
  // The text is exchanged only in this case; throws on every rank.
  if (verdict == Verdict::trouble) comm_.agree(problem);
  return verdict;
}

}  // namespace trackbed::app
