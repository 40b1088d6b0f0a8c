// The log of a run. Lines are printed at intervals of wall time; rank 0 decides, and the agreement
// of the window makes all ranks take part, because the printed values are sums over ranks.
#include "app/run/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace trackbed::app {

namespace {

const char* plural_ending(std::int64_t count) { return count == 1 ? "" : "s"; }

// A line costs sums over all contacts: at intervals of wall time their cost is always negligible.
constexpr double seconds_between_lines = 5;

// To be called on all ranks, though only rank 0 prints: the arguments may be sums over ranks.
// Not fmt::print, which throws where nothing can be written: a run whose log is lost continues.
template <class... Args>
void say(const par::Comm& comm, fmt::format_string<Args...> text, Args&&... args) {
  if (!comm.root()) return;
  std::fputs(fmt::format(text, std::forward<Args>(args)...).c_str(), stdout);
  std::fflush(stdout);
}

double megabytes(std::size_t bytes) { return static_cast<double>(bytes) / (1024 * 1024); }

std::string clock_words(double seconds) {
  const auto s = static_cast<std::int64_t>(seconds);
  return s < 3600 ? fmt::format("{}:{:02d}", s / 60, s % 60)
                  : fmt::format("{}:{:02d}:{:02d}", s / 3600, s / 60 % 60, s % 60);
}

// Remaining simulated time, as far as durations are given. Rough: stages may end early, and
// passages without a duration count 0.
double remaining(const Course& course, const Model& model) {
  double time =
      static_cast<double>(course.clock.windows() - course.clock.window()) * course.clock.dt();
  for (std::size_t i = course.stage + 1; i < model.stages.size(); ++i)
    time += model.stages[i].duration;
  return time;
}

std::string words_of_base(const fem::GroundParameters& ground) {
  if (!ground.mesh.empty()) return "of the mesh " + ground.mesh;
  return ground.base == fem::Base::fixed ? "base fixed" : "base viscous (dashpots)";
}

std::string words_of_springs(const fem::GroundParameters& ground) {
  if (ground.base_stiffness < 0) return " on springs of shear modulus over depth";
  return fmt::format(" on springs of {:g} Pa/m", ground.base_stiffness);
}

}  // namespace

double Progress::wall_time() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool Progress::due() const { return wall_time() - last_line_ > seconds_between_lines; }

// The main properties of the model, to check that it is the intended one.
void Progress::start(World& world, const Model& model, const std::string& name) {
  say(comm_, "trackbed: {} on {} rank{}{}{}\n", name, comm_.size(), plural_ending(comm_.size()),
      model.title.empty() ? "" : ": ", model.title);
  if (world.ground) {
    const fem::GroundTotals totals = world.ground->totals();
    std::string limit;
    const double step = world.ground->stable_step(&limit);
    say(comm_, "  ground: {} elements, {} unknowns, {}{}, {}\n", totals.elements, totals.unknowns,
        words_of_base(model.ground), totals.springs ? words_of_springs(model.ground) : "",
        std::isinf(step) ? "one implicit step per window"
                         : fmt::format("stable step {:.4g} s ({})", step, limit));
  }
  const bool passes = model.has_stage(StageKind::passage) && !model.has_train();
  if (world.sleepers)
    say(comm_, "  sleepers: {} of {:.1f} kg{}\n", world.sleepers->count(), world.sleepers->mass(),
        passes ? fmt::format("; seat load peak {:.4g} kN at {:.2f} km/h, {} axles",
                             model.load.peak / 1e3, model.load.speed * 3.6, model.load.axles.size())
               : "");
  if (world.solids) {
    const fem::BodiesTotals totals = world.solids->bodies().totals();
    say(comm_, "  solids: {} elements, {} unknowns on every rank; {}\n", totals.elements,
        totals.unknowns, model.solid.rails ? "with rails on pads" : "sleepers alone");
  }
  if (!model.has_train()) return;
  const track::TrackParameters& track = model.track.line.track;
  say(comm_,
      "  train: {} at {:.2f} km/h over {:g} m of rail; {} sleepers on springs before the bed, "
      "whose "
      "sleepers carry {:g} rail{}\n",
      fmt::join(model.track.train.vehicles, ", "), model.track.train.speed * 3.6, track.length,
      model.seat.before, model.seat.rails, model.seat.rails == 1 ? "" : "s");
}

// Memory is the largest of all ranks, since that rank fails first.
void Progress::stage_begins(const Stage& stage, const Course& course, World& world) {
  const dem::Totals totals = world.particles.totals();
  const double bytes = comm_.max(megabytes(world.memory()));
  const bool stones = world.model.has_stones();
  say(comm_,
      "stage {}: {}window {:.4g} s{} (limit: {}), up to {:.4g} s = {} windows; {:.2g} MB per "
      "rank\n",
      stage.name,
      stones ? fmt::format("{} stone{} ({} piece{}), ", totals.particles,
                           plural_ending(totals.particles), totals.pieces,
                           plural_ending(totals.pieces))
             : "",
      course.clock.dt(),
      stones ? fmt::format(" in {} sub-step{}", course.steps.substeps,
                           plural_ending(course.steps.substeps))
             : "",
      course.steps.limit, static_cast<double>(course.clock.windows()) * course.clock.dt(),
      course.clock.windows(), bytes);
  last_line_ = wall_time(), last_time_ = course.clock.time();
}

// Speed since the last line and not since the start: stages differ much, and the remaining time
// should follow from the present speed.
void Progress::line(const Course& course, const Model& model, const World& world) {
  const dem::Totals totals = world.particles.totals();
  const std::int64_t deep = world.particles.core_overlaps();
  const double wall = wall_time();
  const double speed = (course.clock.time() - last_time_) / (wall - last_line_);  // s per s
  const std::string when =
      fmt::format("  {:>8.4f} s | {:.3g} ms/s | left {}", course.clock.time(), speed * 1e3,
                  clock_words(speed > 0 ? remaining(course, model) / speed : 0));
  last_line_ = wall, last_time_ = course.clock.time();
  if (!model.has_stones()) {
    const fem::GroundTotals ground = world.ground->totals();
    return say(comm_, "{} | E_kin {:.3g} J, elastic {:.3g} J of the ground\n", when, ground.kinetic,
               ground.elastic);
  }
  say(comm_,
      "{} | E_kin {:.3g} J | overlap {:.3g} um | unbalanced "
      "{:.2g} | {} contacts{}{}\n",
      when, totals.kinetic, totals.largest_overlap * 1e6, totals.unbalanced, totals.contacts,
      deep > 0 ? fmt::format(" | {} times overlapping cores", deep) : "",
      world.platen ? fmt::format(" | platen {:.1f} kPa at {:.4f} m", world.platen->pressure() / 1e3,
                                 world.platen->z())
                   : "");
}

std::unique_ptr<Waiting> Progress::equilibrium(const World& world) {
  const fem::GroundTotals totals = world.ground->totals();
  const std::string what =
      fmt::format("  static equilibrium of the ground, {} unknowns", totals.unknowns);
  say(comm_, "{}\n", what);
  if (!comm_.root()) return nullptr;
  return std::make_unique<Waiting>(what, seconds_between_lines,
                                   [this](const std::string& line) { say(comm_, "{}\n", line); });
}

void Progress::static_iteration(int iterations, double residual) {
  say(comm_,
      "  static equilibrium of the ground: relative out-of-balance force {:.2g} after {} "
      "iterations\n",
      residual, iterations);
  last_line_ = wall_time();
}

void Progress::stage_ends(const StageRecord& record) {
  std::string stones;
  if (record.bulk_density > 0)
    stones = fmt::format("bulk density {:.0f} kg/m3, ", record.bulk_density);
  if (record.platen_pressure >= 0)
    stones += fmt::format("mean platen pressure {:.1f} kPa, ", record.platen_pressure / 1e3);
  say(comm_, "  {} done at {:.6g} s: {}{:.1f} s of wall time\n", record.name, record.time, stones,
      record.wall_time);
  if (record.settlement >= 0)
    say(comm_, "    largest settlement of a sleeper in the last cycle: {:.3g} mm\n",
        1e3 * record.settlement);
}

void Progress::warning(const std::string& sentence) { say(comm_, "warning: {}\n", sentence); }

// imbalance: largest over mean of the ranks. Verbs in which ranks wait for each other (halo,
// coupling) include the imbalance of the others as time.
void Progress::timer_table(const Timers& timers) {
  const double total = comm_.max(wall_time());
  say(comm_, "{:<18}{:>8}{:>10}{:>10}{:>10}{:>11}\n", "time in", "share", "min s", "mean s",
      "max s", "imbalance");
  double counted = 0;  // s, mean over ranks; parts of other verbs aside
  for (std::size_t i = 0; i < static_cast<std::size_t>(Verb::count); ++i) {
    const auto verb = static_cast<Verb>(i);
    const double mine = timers.seconds(verb);
    const double low = comm_.min(mine), high = comm_.max(mine);
    if (high < 0.005) continue;  // a row of zeros: most often a part that this model does not have
    const double mean = comm_.sum(mine) / comm_.size();
    say(comm_, "{:<18}{:>7.1f}%{:>10.2f}{:>10.2f}{:>10.2f}{:>11.2f}\n", name_of(verb),
        100 * mean / total, low, mean, high, mean > 0 ? high / mean : 1);
    if (!is_part(verb)) counted += mean;
  }
  say(comm_, "{:<18}{:>7.1f}%{:>10}{:>10.2f}\n", "other", 100 * (1 - counted / total), "",
      total - counted);
  say(comm_, "{:<18}{:>8}{:>10}{:>10.2f}\n", "all", "", "", total);
}

}  // namespace trackbed::app
