// A train over a track from static equilibrium to the end of the passage. Every rank computes the
// same numbers from the same input; rank 0 prints and writes. More ranks are useful only with a
// ground, which is distributed over them.
#include "app/run/track_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/coupling/track_built.hpp"
#include "app/coupling/wheel_extremes.hpp"
#include "app/deck/deck_files.hpp"
#include "app/parameters/version.hpp"
#include "app/restart/track_resume.hpp"
#include "app/run/interrupt.hpp"
#include "app/run/result_folder.hpp"
#include "app/run/track_ends.hpp"
#include "app/track_rules/track_rules.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/observe/passage.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;
using WallClock = std::chrono::steady_clock;
constexpr double seconds_between_lines = 5;
constexpr std::int64_t steps_between_checks = 50;  // for requests to stop

double seconds_since(WallClock::time_point begin) {
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

// Whole steps: the last one may go a little beyond the duration.
std::int64_t steps_of(const TrackModel& model, const BuiltTrack& built) {
  return static_cast<std::int64_t>(std::ceil(built.passage.duration() / model.passage.step - 1e-9));
}

// In every step, so that extremes do not depend on the interval of the histories. Wheels on the
// rigid rails before and behind the track, and in the run-ins, are left out.
void record_wheels(const TrackModel& model, const BuiltTrack& built, WheelExtremes& wheels) {
  const Range open = between_run_ins(model.line.track);
  for (std::size_t i = 0; i < built.train.wheels().size(); ++i)
    if (const double x = built.passage.wheel_x(i); x >= open.from && x <= open.to)
      wheels.add(built.passage.wheel_force(i));
}

// Describes the lowest position of a rail, m.
std::string words_of_lowest(double lowest) {
  const std::string far = fmt::format("{:.4f} mm", std::abs(1e3 * lowest));
  return lowest > 0 && far != "0.0000 mm" ? "always at least " + far + " above its level"
                                          : "down to " + far;
}

// Prints the results of a finished run; wheel forces only if a wheel was on the track.
void print_results(const par::Comm& comm, const TrackModel& model, const BuiltTrack& built,
                   const WheelExtremes& wheels, const std::vector<double>& lowest) {
  const std::size_t sides = built.line.sides();
  const bool by_train = model.passage.loaded_by == track::LoadedBy::train;
  for (std::size_t i = 0; by_train && i < lowest.size(); ++i)
    say(comm, fmt::format("  {}rail at {:g} m: {}",
                          sides == 1   ? ""
                          : i % 2 == 0 ? "left "
                                       : "right ",
                          model.passage.points[i / sides], words_of_lowest(lowest[i])));
  if (!wheels.any) return;
  const Range open = between_run_ins(model.line.track);
  say(comm, fmt::format("  wheels: {:.2f} to {:.2f} kN{}", wheels.least / 1e3, wheels.most / 1e3,
                        open.from > 0 ? fmt::format(", between the run-ins ({:g} to {:g} m)",
                                                    open.from, open.to)
                                      : ""));
}

// Hash of the whole motion, to compare runs bitwise.
std::string state_hash(const track::Passage& passage) {
  std::uint64_t hash = 0;
  for (const track::Newmark* motion : {&passage.line_motion(), &passage.train_motion()})
    for (const track::Vector* values :
         {&motion->displacement, &motion->velocity, &motion->acceleration})
      hash = mix(hash + hash_bytes(values->data(),
                                   sizeof(double) * static_cast<std::size_t>(values->size())));
  return fmt::format("{:016x}", hash);
}

// Of the profile itself, and of its spectrum if it was drawn from one.
void put_d1(Json& json, const std::string& section, const track::IrregularityParameters& given,
            const track::Irregularity& profile) {
  json[section + "_d1_rms_m"] = profile.d1_rms();
  if (given.kind == track::IrregularityKind::spectrum)
    json[section + "_spectrum_d1_rms_m"] = profile.spectrum_d1_rms();
}

// Names are those of summary.json of other runs where the meaning is the same; a window is a step.
Json figures(const TrackModel& model, const BuiltTrack& built, const WheelExtremes& wheels,
             const std::vector<double>& lowest) {
  const track::Passage& passage = built.passage;
  const auto steps = static_cast<double>(std::max<std::int64_t>(passage.steps(), 1));
  Json json{{"unknowns", built.line.system().mass.rows()},
            {"sleepers", built.line.sleepers()},
            {"wheels", built.train.wheels().size()},
            {"steps", passage.steps()},
            {"iterations_mean", static_cast<double>(passage.iterations()) / steps},
            {"wheel_rail_constant", built.law.constant()},
            {"wheel_steps_off_rail", passage.lost()},
            {"rail_lowest_m", lowest},
            {"state_hash", state_hash(passage)}};
  if (wheels.any) json["wheel_force_max_n"] = wheels.most, json["wheel_force_min_n"] = wheels.least;
  if (model.irregularity.kind != track::IrregularityKind::none)
    put_d1(json, "irregularity", model.irregularity, built.irregularity);
  if (built.right) put_d1(json, "irregularity_right", model.irregularity_right, *built.right);
  return json;
}

// A run of a track: model, state, histories and checkpoints.
class Run {
 public:
  Run(const par::Comm& comm, TrackAssembly& whole, const TrackRunInput& of)
      : built(whole.track, whole.line),
        histories(built.line, built.train, whole.track.passage.points,
                  whole.track.passage.forces.size()),
        comm_(comm),
        model_(whole.track),
        below_(whole.below),
        of_(of) {}

  // Whether it finished; histories are written then, and when it is stopped or fails.
  bool run();
  void resume();

  BuiltTrack built;
  observe::PassageHistories histories;
  WheelExtremes wheels;
  std::vector<std::string> changed;  // changes by resumes: the results contain only the last deck

 private:
  bool advance_all();
  void write_histories();
  void record();
  bool stops_here() const;
  void check_ground() const;
  void progress(std::int64_t steps);
  void checkpoint();
  void save(io::File& file) const;

  const par::Comm& comm_;
  const TrackModel& model_;
  std::optional<GroundBelow>& below_;
  const TrackRunInput& of_;
  const std::string files_ = contents_of_files(comm_, of_.effective);
  WallClock::time_point begin_ = WallClock::now();
  double last_line_ = 0;  // s of wall time
  std::int64_t resumed_at_ = 0;
  std::vector<std::string> periodic_;  // checkpoints of this run, the oldest first
};

std::int64_t steps_in(double interval, double step) {
  return std::max<std::int64_t>(1, std::llround(interval / step));
}

// Adds to error messages the time and the last checkpoint, as in a run of a bed. Histories are
// written also after an error, which all ranks have at the same step.
bool Run::run() {
  try {
    const bool finished = advance_all();
    write_histories();
    return finished;
  } catch (const RunError& error) {
    try {
      write_histories();
    } catch (const RunError&) {  // for example a full disk; the first error is reported
    }
    const std::string last = periodic_.empty() ? of_.checkpoint : periodic_.back();
    throw RunError(fmt::format("{} (at {:.6g} s); {}", error.what(), built.passage.time(),
                               what_is_left(last, "")));
  }
}

void Run::write_histories() {
  histories.write(comm_, of_.folder + "/results.h5", {.deck = of_.effective, .version = version()});
}

// Rows and checkpoints are counted in steps from the start: a resumed run has them at the same
// steps.
bool Run::advance_all() {
  const TrackOutput& passage = model_.passage;
  const std::int64_t steps = steps_of(model_, built);
  const std::int64_t row = steps_in(passage.history_interval, passage.step);
  const std::int64_t written = steps_in(passage.checkpoint_interval, passage.step);
  catch_interrupts();
  if (built.passage.steps() == 0) {
    histories.sample(built.passage);
    record();
  }
  while (built.passage.steps() < steps) {
    if (below_)
      below_->advance(built.passage);
    else
      built.passage.advance();
    record();
    const std::int64_t done = built.passage.steps();
    if (done % row == 0) histories.sample(built.passage);
    progress(steps);
    if (done == steps) check_ground();
    if (done < steps && stops_here()) {
      checkpoint();
      return false;
    }
    if (passage.checkpoint_interval > 0 && done % written == 0) checkpoint();
  }
  return true;
}

void Run::record() {
  record_wheels(model_, built, wheels);
  histories.update_extremes(built.passage);
}

// Signals may reach any rank and clocks differ: all ranks agree, but not in every step, which may
// take less time than a message.
bool Run::stops_here() const {
  const std::int64_t done = built.passage.steps();
  if (model_.passage.stop_after > 0 && done == model_.passage.stop_after) return true;
  if (done % steps_between_checks != 0) return false;
  check_ground();
  const bool late = comm_.root() && model_.passage.wall_time > 0 &&
                    seconds_since(begin_) > model_.passage.wall_time;
  return comm_.max(std::int64_t{interrupted() || late}) != 0;
}

void Run::progress(std::int64_t steps) {
  const double wall = seconds_since(begin_);
  if (!comm_.root() || wall < last_line_ + seconds_between_lines) return;
  last_line_ = wall;
  const std::int64_t done = built.passage.steps();
  const double left =
      wall * static_cast<double>(steps - done) / static_cast<double>(done - resumed_at_);
  std::string line = fmt::format("  {:>8.4f} s | left {:.0f} s", built.passage.time(), left);
  if (!built.train.wheels().empty())
    line += fmt::format(" | first wheel at {:.2f} m, {:.2f} kN", built.passage.wheel_x(0),
                        built.passage.wheel_force(0) / 1e3);
  say(comm_, line);
}

// Called before a state is written, and at the end.
void Run::check_ground() const {
  if (below_) comm_.agree(below_->trouble());
}

// Two are kept, as in runs of a bed: a disk that fills up while writing must not destroy both.
void Run::checkpoint() {
  check_ground();
  const std::string name = fmt::format("checkpoint_{:010d}.h5", built.passage.steps());
  io::write_checkpoint(comm_, of_.folder, name, [&](io::File& file) { save(file); });
  periodic_.push_back(of_.folder + "/" + name);
  if (periodic_.size() <= 2) return;
  std::error_code ignored;
  if (comm_.root()) std::filesystem::remove(periodic_.front(), ignored);
  periodic_.erase(periodic_.begin());
}

// The attributes are those of a bed's checkpoint, which `trackbed info` reads.
void Run::save(io::File& file) const {
  file.attribute("/", "version", version());
  file.attribute("/", "deck", of_.effective);
  if (!files_.empty()) file.attribute("/", "files", files_);
  if (!changed.empty()) file.attribute("/", "changed", fmt::format("{}", fmt::join(changed, "\n")));
  file.attribute("/", "deck_name", of_.deck);
  file.attribute("/", "stage", std::string("passage"));
  file.attribute("/", "stage_finished", std::int64_t{0});
  file.attribute("/", "time", built.passage.time());
  file.attribute("/", "particles", std::int64_t{0});
  built.passage.save(file, "train", comm_);
  if (below_) below_->save(file);
  histories.save(file, comm_);
  wheels.save(file, comm_);
}

void Run::resume() {
  remove_parts(comm_, of_.folder);
  const io::File file = io::open_checkpoint(comm_, of_.checkpoint);
  built.passage.load(file, "train");
  if (below_) below_->load(file);
  histories.load(file);
  wheels.load(file);
  resumed_at_ = built.passage.steps();
  changed = changed_on_resumes(comm_, file, of_.effective);
  for (const std::string& change : changed) say(comm_, "warning: " + change);
  say(comm_, fmt::format("  continues at {:.6g} s from {}", built.passage.time(), of_.checkpoint));
}

// Result of a run besides its model and its state.
struct RunOutcome {
  std::string deck;
  bool finished;
  double wall, stepping;                             // s
  std::vector<std::string> deck_warnings, warnings;  // of the deck; of its files and of the run
};

Json summary_of(const par::Comm& comm, const TrackAssembly& whole, const Run& run,
                const RunOutcome& outcome) {
  const bool alone = !whole.below;
  Json json{{"deck", outcome.deck},
            {"model", alone ? "track" : "track_on_ground"},
            {"finished", outcome.finished},
            {"ranks", comm.size()},
            {"simulated_time_s", run.built.passage.time()},
            {"wall_time_s", outcome.wall},
            {"windows", run.built.passage.steps()}};
  json["track"] = figures(whole.track, run.built, run.wheels, run.histories.lowest());
  const double moving = comm.max(outcome.stepping) / outcome.wall;
  const double ground = alone ? 0 : comm.max(whole.below->seconds()) / outcome.wall;
  json["share"] = {{"track", moving - ground}, {"other", 1 - moving}};
  json["energy"] = {{"track_j", run.built.passage.track_energy()}};
  if (!alone) {
    json["share"]["ground"] = ground;
    json["ground"] = whole.below->figures();
    json["coupling"] = whole.below->balance();
    json["energy"] = whole.below->energies(run.built.passage);
  }
  std::vector<std::string> warnings = outcome.deck_warnings;
  warnings.insert(warnings.end(), outcome.warnings.begin(), outcome.warnings.end());
  warnings.insert(warnings.end(), run.changed.begin(), run.changed.end());
  json["warnings"] = warnings;
  return json;
}

}  // namespace

// Histories and summary are written at the end, or when the run is stopped. A killed run leaves
// only its periodic checkpoints.
bool run_track(const par::Comm& comm, const Model& model, const TrackRunInput& of) {
  const WallClock::time_point begin = WallClock::now();
  TrackAssembly whole(comm, model);
  const bool alone = !whole.below;
  say(comm, fmt::format("trackbed: {} on {} rank{}", of.deck, comm.size(),
                        comm.size() == 1 ? ""
                        : alone          ? "s, each of which computes the whole track"
                                         : "s; the ground is distributed over them"));
  Run run(comm, whole, of);
  std::vector<std::string> warnings = introduce(comm, model, whole, run.built);
  if (!of.checkpoint.empty()) run.resume();
  const WallClock::time_point moving = WallClock::now();
  const bool finished = run.run();
  const double stepping = seconds_since(moving);
  const double wall = comm.max(seconds_since(begin));
  const TrackModel& track = whole.track;
  std::vector<std::string> at_end;
  if (finished) at_end = warnings_of_passage(track, run.built, run.wheels, run.histories.lowest());
  warnings.insert(warnings.end(), at_end.begin(), at_end.end());
  write_summary_file(
      comm, of.folder,
      summary_of(comm, whole, run, {of.deck, finished, wall, stepping, of.warnings, warnings})
          .dump(2));
  if (finished) print_results(comm, track, run.built, run.wheels, run.histories.lowest());
  for (const std::string& warning : at_end) say(comm, "warning: " + warning);
  say(comm,
      fmt::format("  {} steps of {:g} s, {:.2f} s of wall time for {:.4g} s",
                  run.built.passage.steps(), track.passage.step, wall, run.built.passage.time()));
  say(comm, finished ? "results: " + of.folder
                     : "stopped early; continue with: trackbed resume " + of.folder);
  return finished;
}

// Measured on some steps from the start, where most wheels may still be on rigid rails: their cost
// is the same.
void check_track(const par::Comm& comm, const Model& model) {
  TrackAssembly whole(comm, model);
  BuiltTrack built(whole.track, whole.line);
  introduce(comm, model, whole, built);
  constexpr int tried = 50;
  const std::int64_t steps = steps_of(whole.track, built);
  const WallClock::time_point begin = WallClock::now();
  for (int i = 0; i < tried; ++i) {
    if (whole.below)
      whole.below->advance(built.passage);
    else
      built.passage.advance();
  }
  const double each = seconds_since(begin) / tried;
  say(comm, fmt::format("  passage: {:.4g} s in {} steps, about {:.0f} s of wall time",
                        built.passage.duration(), steps, each * static_cast<double>(steps)));
}

}  // namespace trackbed::app
