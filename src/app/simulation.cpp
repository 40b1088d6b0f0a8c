// The run: a loop over stages, in each a loop over windows. What is in a window is in `window`,
// what is around it in `run_stages`; both are to stay as short as they are. One agreement per
// window covers trouble on any rank, signals, the wall-time limit and reports, and costs one
// reduction.
//
// Errors known on one rank only wait for this agreement: until then the rank goes on with what it
// has, so that no rank ever waits in a collective call for one that has left.
#include "app/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/deck_files.hpp"
#include "app/doubts.hpp"
#include "app/interrupt.hpp"
#include "app/placed_words.hpp"
#include "app/result_folder.hpp"
#include "app/shear.hpp"
#include "app/summary.hpp"
#include "app/version.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

// Rounded up, so that a stage is never shorter than asked; the margin keeps 0.3/0.1 at 3.
// At least one: a stage of no windows would never be begun and ended in order.
std::int64_t whole_windows(double duration, double window) {
  return std::max<std::int64_t>(1, std::llround(std::ceil(duration / window * (1 - 1e-9))));
}

// Sums of loads get room as loads grow (Particles::expect_load), and a bed that is poured grows
// slowly. One that is laid from copies weighs all at once, and its floor may have one node for a
// thousand of them. Eight times what is expected has room: the weight for copies, which may still
// shake and then press with twice their weight; a quarter of it for other beds, so that those that
// have room already keep their bits. Collective.
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
// stones' mean forces of the last window, then the stones follow their linear motion.
// Not iterated: each iteration would cost a whole window of stones; what the delay of the load does
// instead is bounded by coupling_limit.
// (Serial staggered scheme: Felippa, Park, Farhat 2001, doi:10.1016/S0045-7825(00)00391-1.) The
// order is track, ground, stones; within a window neither of the first two sees the other, only the
// stones' mean forces, so their order does not matter.
void Simulation::window() {
  const double dt = course_.clock.dt();
  move_sleepers(dt);
  press_platen(dt);
  move_walls(world_, course_.stage, static_cast<double>(course_.clock.window()) * dt, dt);
  if (world_.placement) world_.placement->show(course_.clock.time(), dt);
  move_ground(dt);
  move_stones(dt);
  if (world_.placement) world_.placement->watch(world_.particles, world_.on_placed(), dt);
  average_support(dt);
}

// Loads are taken at mid-window: second order in the window for a load that varies smoothly. Of a
// train: at its begin, from which leapfrog kicks; the rail then follows to where the sleepers went.
// The stones' reaction is the mean of the last window, N: first order in the window, and what the
// coupling limit is about. Local: every rank moves all sleepers alike.
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

// An implicit step takes the loads of its end. Axles run on the rails, if there are any; what comes
// to the seats is known afterwards. So it is of a train, whose rail takes the same step.
void Simulation::move_solids(double dt) {
  const double end = (static_cast<double>(course_.clock.window()) + 1) * dt;
  world_.solids->roll(actions_.axles(stage(), end));
  world_.solids->advance(dt, actions_.seat_forces(stage(), end), world_.on_sleepers(),
                         model_.dem.gravity);
  actions_.move_train(stage(), course_.clock);
  seat_force_ = world_.solids->seat_forces();
}

// In the compact and shear stages the servo decides, in release and triaxial stages the deck.
// Release: the speed is given, so the reaction of the bed does nothing. In the first window there
// is no last motion yet to carry out.
void Simulation::press_platen(double dt) {
  if (!world_.platen) return;
  const double time = static_cast<double>(course_.clock.window()) * dt;
  if (stage().kind == StageKind::release) {
    world_.lift_platen(course_.clock.window() > 0 ? stage().lift * dt : 0, stage().lift * dt);
    return;
  }
  world_.platen->cover(world_.walls.area());
  if (stage().kind == StageKind::triaxial) return push_platen(world_, stage(), time, dt);
  aim_platen(world_, course_.stage, time, dt);
  world_.platen->advance(dt, world_.on_platen());
}

// A ground that is held still keeps its shape but still collects the load of the bed.
// The position at the begin of the window plus the motion in it is where the nodes are: the first
// window of rest has to take over the last motion.
void Simulation::move_ground(double dt) {
  if (!world_.ground) return;
  const auto timing = timers_.scope(Verb::ground);
  if (stage().ground_moves) {
    if (world_.pressures) return press_ground(dt);
    world_.ground->advance(dt, world_.on_ground());
    return;
  }
  Surface& top = world_.ground->top();  // stays where its last motion ended
  for (const std::int32_t own : world_.ground->own_top()) {
    const auto node = static_cast<std::size_t>(own);
    top.position[node] += top.motion[node];
    top.motion[node].setZero();
  }
}

// Nothing else presses on a ground alone. Each step has the loads of its begin and of its end: one
// that is constant in a window, as that of stones, shows velocities of the top a first order late.
void Simulation::press_ground(double dt) {
  const double begin = course_.clock.time();
  const auto load_at = [&](double time) {
    load_.assign(world_.ground->top().nodes(), Vec3::Zero());
    world_.pressures->add(time, load_);
    return std::span<const Vec3>(load_);
  };
  if (course_.windows == 0) world_.ground->begin_under(load_at(0));
  if (model_.ground.integrator != fem::Integrator::explicit_)
    return world_.ground->advance(dt, load_at(begin + dt));
  const auto steps = whole_windows(dt, world_.ground->stable_step());
  const double step = dt / static_cast<double>(steps);
  for (std::int64_t k = 1; k <= steps; ++k) {
    world_.ground->begin_step(step);
    world_.ground->end_step(load_at(begin + static_cast<double>(k) * step));
  }
}

// Scopes are narrow so that waiting for surfaces is booked under coupling, not under dem.
// The stones' own account of what they gave to surfaces goes along: force, moment and work of both
// sides are compared (docs/glossary.md, balance).
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

// Exponential mean, so that it costs one number per node and needs no history.
//   s += (dt/T) (f - s),   T = settle_average, s
// with f the force of this window, N. A window longer than T takes the last force as it is. Own
// nodes only: forces are valid there.
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

// Errors leave with the words a user needs to go on: when, where, and from which checkpoint.
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
// its line and its checkpoint come after the agreement: they are collective, and in a run in
// trouble ranks must not part there.
Outcome Simulation::run_stages() {
  catch_interrupts();
  progress_.start(world_, model_, name_);
  // Where sleepers stand or are going to stand: their number is the width of their histories.
  std::vector<double> sleeper_x;
  for (std::size_t i = 0; world_.sleepers && i < world_.sleepers->count(); ++i)
    sleeper_x.push_back(world_.sleepers->x(i));
  results_.watch(world_.scene(), world_.watched, sleeper_x, model_.regions);
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
  // The loop left it one beyond the end, where there is no stage to name.
  course_.stage = model_.stages.size() - 1;
  for (const std::string& doubt : doubts_of_end(world_, stage().kind)) warn(doubt);
  write_summary(true);
  return Outcome::finished;
}

// Asked again for the same window by a run that resumes there: must depend on state alone.
// Collective, since `settled` is.
bool Simulation::runs() const {
  return course_.clock.runs() && !actions_.settled(stage(), course_.clock);
}

// Envelopes are those of the last passage: earlier ones bed the sleepers in.
bool Simulation::is_last_passage() const {
  if (stage().kind != StageKind::passage) return false;
  for (std::size_t later = course_.stage + 1; later < model_.stages.size(); ++later)
    if (model_.stages[later].kind == StageKind::passage) return false;
  return true;
}

// The clock of a stage counts its windows from 0, so that stages of different windows follow each
// other without rounding.
// Steps are chosen after the stage's own stones and bodies are there: they are what limits them.
// False if the run is to stop instead, with nothing done that a checkpoint could hold.
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

// The ground is let go under the averaged load of the bed, so that it neither jumps nor sinks when
// it starts to move. Layers that yield may take their time, which is told, and may be stopped.
// Collective.
bool Simulation::settle_ground() {
  if (!stage().ground_moves || !world_.ground || world_.ground_settled) return true;
  const auto timing = timers_.scope(Verb::ground);
  if (world_.pressures) world_.pressures->add_dead(world_.support);
  const auto waiting = progress_.equilibrium(world_);
  world_.ground_settled = world_.ground->settle(world_.support, [this](int rounds, double flows) {
    if (comm_.root() && progress_.due()) progress_.rest(rounds, flows);
    return comm_.max(std::int64_t{is_to_stop()}) == 0;
  });
  return world_.ground_settled;
}

// The checkpoint comes last: it holds the state after the end of the stage.
// A run that is resumed from it begins with the next stage. `actions_.end` may take stones away
// (cribs), so what describes the stage itself is written before it.
void Simulation::end_stage() {
  {
    const auto timing = timers_.scope(Verb::output);
    if (model_.has_stones())
      results_.snapshot(stage().name, world_.scene(),
                        model_.has_bed() ? model_.output.surface_cell : 0);
    results_.flush();
    if (is_last_passage()) results_.envelope(static_cast<std::int64_t>(course_.stage));
    if (model_.output.fields) {
      if (keeps_extremes()) world_.ground->take_extremes();  // its last window is hardly a row's
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

// A stage that ran out of time or missed its bed goes on to the next, with a warning: whether the
// bed is good enough is the user's to judge, and the checkpoint of the stage is there.
void Simulation::judge(const StageRecord& record, const std::string& shortfall) {
  if (!shortfall.empty())
    warn(fmt::format("stage {} ended after {:.4g} s without reaching its aim: {}", record.name,
                     record.duration, shortfall));
  if (stage().kind != StageKind::compact) return;
  const std::span<const Stage> done = std::span(model_.stages).first(course_.stage + 1);
  if (const std::string doubt = doubt_of_bed(world_, done); !doubt.empty())
    warn(fmt::format("stage {}: {}", record.name, doubt));
}

// Said at once, and once more in summary.json. Local, but the same on all ranks.
void Simulation::warn(const std::string& sentence) {
  course_.warnings.push_back(sentence);
  progress_.warning(sentence);
}

// Signals may reach any rank; time is asked on rank 0 alone, since clocks of nodes differ.
bool Simulation::is_to_stop() const {
  const bool out_of_time = comm_.root() && model_.output.wall_time > 0 &&
                           progress_.wall_time() > model_.output.wall_time;
  return interrupted() || out_of_time;
}

// The one agreement of a window: trouble anywhere, a wish to stop, a report due.
Simulation::Verdict Simulation::agree() {
  std::string problem = world_.particles.trouble();
  if (world_.placement && !problem.empty()) problem = by_names(problem, world_);
  if (problem.empty() && world_.ground) problem = world_.ground->trouble();
  if (problem.empty() && world_.sleepers) problem = world_.sleepers->trouble();
  if (problem.empty()) problem = world_.coupler.trouble();
  // Ordered by weight, so that the maximum over ranks is what happens: trouble before all.
  Verdict mine = Verdict::go_on;
  if (comm_.root() && progress_.due()) mine = Verdict::report;
  const bool far_enough =
      model_.output.stop_after > 0 && course_.windows == model_.output.stop_after;
  if (is_to_stop() || far_enough) mine = Verdict::stop;
  if (!problem.empty()) mine = Verdict::trouble;
  const auto verdict = static_cast<Verdict>(comm_.max(static_cast<std::int64_t>(mine)));
  // The text travels only now; throws on every rank.
  if (verdict == Verdict::trouble) comm_.agree(problem);
  return verdict;
}

}  // namespace trackbed::app
