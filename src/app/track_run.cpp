// A train over a track from equilibrium to the end of the passage. Every rank computes the same
// numbers from the same input; rank 0 prints and writes. More ranks bring nothing, and change
// nothing, unless there is a ground below, which they share.
#include "app/track_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/deck_files.hpp"
#include "app/interrupt.hpp"
#include "app/result_folder.hpp"
#include "app/track_built.hpp"
#include "app/track_ends.hpp"
#include "app/track_rules.hpp"
#include "app/version.hpp"
#include "app/wheel_extremes.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/observe/passage.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;
using Watch = std::chrono::steady_clock;
constexpr double seconds_between_lines = 5;
constexpr std::int64_t steps_between_looks = 50;  // for wishes to stop

double seconds_since(Watch::time_point begin) {
  return std::chrono::duration<double>(Watch::now() - begin).count();
}

// Whole steps: the last one may go a little beyond the duration.
std::int64_t steps_of(const TrackModel& model, const Built& built) {
  return static_cast<std::int64_t>(std::ceil(built.passage.duration() / model.passage.step - 1e-9));
}

// Every step, whether it makes a row or not: extremes do not depend on the interval of the
// histories. Wheels on the rigid rails before and behind the track, and on rails that become so,
// have nothing to tell of it.
void see_wheels(const TrackModel& model, const Built& built, WheelExtremes& wheels) {
  const Way open = between_run_ins(model.line.track);
  for (std::size_t i = 0; i < built.train.wheels().size(); ++i)
    if (const double x = built.passage.wheel_x(i); x >= open.from && x <= open.to)
      wheels.see(built.passage.wheel_force(i));
}

// Of the lowest place of a rail, m.
std::string words_of_lowest(double lowest) {
  const std::string far = fmt::format("{:.4f} mm", std::abs(1e3 * lowest));
  return lowest > 0 && far != "0.0000 mm" ? "never lower than " + far + " up" : "down to " + far;
}

// Where the wheels have not been is nothing to tell.
void conclude(const par::Comm& comm, const TrackModel& model, const Built& built,
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
  const Way open = between_run_ins(model.line.track);
  say(comm, fmt::format("  wheels: {:.2f} to {:.2f} kN{}", wheels.least / 1e3, wheels.most / 1e3,
                        open.from > 0 ? fmt::format(", between the run-ins ({:g} to {:g} m)",
                                                    open.from, open.to)
                                      : ""));
}

// All that moves, to tell whether two runs did the same to the last bit.
std::string state_hash(const track::Passage& passage) {
  std::uint64_t hash = 0;
  for (const track::Newmark* motion : {&passage.line_motion(), &passage.train_motion()})
    for (const track::Vector* values :
         {&motion->displacement, &motion->velocity, &motion->acceleration})
      hash = mix(hash + hash_bytes(values->data(),
                                   sizeof(double) * static_cast<std::size_t>(values->size())));
  return fmt::format("{:016x}", hash);
}

// Of the profile as it lies, and of all those that its spectrum may give.
void put_d1(Json& json, const std::string& section, const track::IrregularityParameters& given,
            const track::Irregularity& profile) {
  json[section + "_d1_rms_m"] = profile.d1_rms();
  if (given.kind == track::IrregularityKind::spectrum)
    json[section + "_spectrum_d1_rms_m"] = profile.spectrum_d1_rms();
}

// Names as in summary.json of other runs where they mean the same; a window is a step.
Json figures(const TrackModel& model, const Built& built, const WheelExtremes& wheels,
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

// A run under way: what moves, what is kept of it, and where it was last written down.
class Run {
 public:
  Run(const par::Comm& comm, Together& whole, const TrackRunOf& of)
      : built(whole.track, whole.line),
        histories(built.line, built.train, whole.track.passage.points,
                  whole.track.passage.forces.size()),
        comm_(comm),
        model_(whole.track),
        below_(whole.below),
        of_(of) {}

  // Whether it came to its end; histories are written then, and when it is stopped or fails.
  bool run();
  void resume();

  Built built;
  observe::PassageHistories histories;
  WheelExtremes wheels;
  std::vector<std::string> changed;  // what resumes changed: the deck in the results is the last

 private:
  bool go();
  void write_histories();
  void see();
  bool stops_here() const;
  void look_for_trouble() const;
  void progress(std::int64_t steps);
  void checkpoint();
  void save(io::File& file) const;

  const par::Comm& comm_;
  const TrackModel& model_;
  std::optional<GroundBelow>& below_;
  const TrackRunOf& of_;
  const std::string files_ = contents_of_files(comm_, of_.effective);
  Watch::time_point begin_ = Watch::now();
  double said_ = 0;  // s of wall time
  std::int64_t resumed_at_ = 0;
  std::vector<std::string> periodic_;  // checkpoints of this run, the oldest first
};

std::int64_t steps_in(double interval, double step) {
  return std::max<std::int64_t>(1, std::llround(interval / step));
}

// Errors leave with the words a user needs to go on, as in a run of a bed, and leave what has been
// computed, for all ranks have them at the same step. A disk may be too full for that.
bool Run::run() {
  try {
    const bool finished = go();
    write_histories();
    return finished;
  } catch (const RunError& error) {
    try {
      write_histories();
    } catch (const RunError&) {  // of the first error is told, it came before
    }
    const std::string last = periodic_.empty() ? of_.checkpoint : periodic_.back();
    throw RunError(fmt::format("{} (at {:.6g} s); {}", error.what(), built.passage.time(),
                               what_is_left(last, "")));
  }
}

void Run::write_histories() {
  histories.write(comm_, of_.folder + "/results.h5", {.deck = of_.effective, .version = version()});
}

// Rows and checkpoints are counted in steps from the begin: a resumed run has them at the same
// ones.
bool Run::go() {
  const TrackOutput& passage = model_.passage;
  const std::int64_t steps = steps_of(model_, built);
  const std::int64_t row = steps_in(passage.history_interval, passage.step);
  const std::int64_t written = steps_in(passage.checkpoint_interval, passage.step);
  catch_interrupts();
  if (built.passage.steps() == 0) {
    histories.sample(built.passage);
    see();
  }
  while (built.passage.steps() < steps) {
    if (below_)
      below_->advance(built.passage);
    else
      built.passage.advance();
    see();
    const std::int64_t done = built.passage.steps();
    if (done % row == 0) histories.sample(built.passage);
    progress(steps);
    if (done == steps) look_for_trouble();
    if (done < steps && stops_here()) {
      checkpoint();
      return false;
    }
    if (passage.checkpoint_interval > 0 && done % written == 0) checkpoint();
  }
  return true;
}

void Run::see() {
  see_wheels(model_, built, wheels);
  histories.see(built.passage);
}

// Signals may reach any rank and clocks differ: asked of all, but not in every step, which may take
// less than a message.
bool Run::stops_here() const {
  const std::int64_t done = built.passage.steps();
  if (model_.passage.stop_after > 0 && done == model_.passage.stop_after) return true;
  if (done % steps_between_looks != 0) return false;
  look_for_trouble();
  const bool late = comm_.root() && model_.passage.wall_time > 0 &&
                    seconds_since(begin_) > model_.passage.wall_time;
  return comm_.max(std::int64_t{interrupted() || late}) != 0;
}

void Run::progress(std::int64_t steps) {
  const double wall = seconds_since(begin_);
  if (!comm_.root() || wall < said_ + seconds_between_lines) return;
  said_ = wall;
  const std::int64_t done = built.passage.steps();
  const double left =
      wall * static_cast<double>(steps - done) / static_cast<double>(done - resumed_at_);
  std::string line = fmt::format("  {:>8.4f} s | left {:.0f} s", built.passage.time(), left);
  if (!built.train.wheels().empty())
    line += fmt::format(" | first wheel at {:.2f} m, {:.2f} kN", built.passage.wheel_x(0),
                        built.passage.wheel_force(0) / 1e3);
  say(comm_, line);
}

// Before a state is written down, or is the last.
void Run::look_for_trouble() const {
  if (below_) comm_.agree(below_->trouble());
}

// Two are kept, as of runs of a bed: a disk that fills up while writing must not cost both.
void Run::checkpoint() {
  look_for_trouble();
  const std::string name = fmt::format("checkpoint_{:010d}.h5", built.passage.steps());
  io::write_checkpoint(comm_, of_.folder, name, [&](io::File& file) { save(file); });
  periodic_.push_back(of_.folder + "/" + name);
  if (periodic_.size() <= 2) return;
  std::error_code ignored;
  if (comm_.root()) std::filesystem::remove(periodic_.front(), ignored);
  periodic_.erase(periodic_.begin());
}

// Attributes as those of a bed, which `trackbed info` reads.
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
  say(comm_, fmt::format("  goes on at {:.6g} s from {}", built.passage.time(), of_.checkpoint));
}

// How a run went, beside its model and its state.
struct Went {
  std::string deck;
  bool finished;
  double wall, stepping;                  // s
  std::vector<std::string> said, doubts;  // of the deck, of its files
};

Json summary_of(const par::Comm& comm, const Together& whole, const Run& run, const Went& went) {
  const bool alone = !whole.below;
  Json json{{"deck", went.deck},
            {"model", alone ? "track" : "track_on_ground"},
            {"finished", went.finished},
            {"ranks", comm.size()},
            {"simulated_time_s", run.built.passage.time()},
            {"wall_time_s", went.wall},
            {"windows", run.built.passage.steps()}};
  json["track"] = figures(whole.track, run.built, run.wheels, run.histories.lowest());
  const double moving = comm.max(went.stepping) / went.wall;
  const double ground = alone ? 0 : comm.max(whole.below->seconds()) / went.wall;
  json["share"] = {{"track", moving - ground}, {"other", 1 - moving}};
  json["energy"] = {{"track_j", run.built.passage.track_energy()}};
  if (!alone) {
    json["share"]["ground"] = ground;
    json["ground"] = whole.below->figures();
    json["coupling"] = whole.below->balance();
    json["energy"] = whole.below->energies(run.built.passage);
  }
  std::vector<std::string> warnings = went.said;
  warnings.insert(warnings.end(), went.doubts.begin(), went.doubts.end());
  warnings.insert(warnings.end(), run.changed.begin(), run.changed.end());
  json["warnings"] = warnings;
  return json;
}

}  // namespace

// Read again when the model is built: they are small.
void require_files(const TrackModel& model) {
  for (const auto* one : {&model.irregularity, &model.irregularity_right})
    if (one->kind == track::IrregularityKind::file)
      track::Irregularity(*one, model.line.track.length);
  seats_of(model);
}

// Histories and summary come at the end, or when the run is stopped. A run that is killed has left
// its checkpoints, if it was asked for some.
bool run_track(const par::Comm& comm, const Model& model, const TrackRunOf& of) {
  const Watch::time_point begin = Watch::now();
  Together whole(comm, model);
  const bool alone = !whole.below;
  say(comm, fmt::format("trackbed: {} on {} rank{}", of.deck, comm.size(),
                        comm.size() == 1 ? ""
                        : alone          ? "s, each of which computes the whole track"
                                         : "s, which share the ground"));
  Run run(comm, whole, of);
  std::vector<std::string> doubts = introduce(comm, model, whole, run.built);
  if (!of.checkpoint.empty()) run.resume();
  const Watch::time_point moving = Watch::now();
  const bool finished = run.run();
  const double stepping = seconds_since(moving);
  const double wall = comm.max(seconds_since(begin));
  const TrackModel& track = whole.track;
  std::vector<std::string> at_end;
  if (finished) at_end = doubts_of_passage(track, run.built, run.wheels, run.histories.lowest());
  doubts.insert(doubts.end(), at_end.begin(), at_end.end());
  write_summary_file(
      comm, of.folder,
      summary_of(comm, whole, run, {of.deck, finished, wall, stepping, of.warnings, doubts})
          .dump(2));
  if (finished) conclude(comm, track, run.built, run.wheels, run.histories.lowest());
  for (const std::string& doubt : at_end) say(comm, "warning: " + doubt);
  say(comm,
      fmt::format("  {} steps of {:g} s, {:.2f} s of wall time for {:.4g} s",
                  run.built.passage.steps(), track.passage.step, wall, run.built.passage.time()));
  say(comm, finished ? "results: " + of.folder
                     : "stopped early; go on with: trackbed resume " + of.folder);
  return finished;
}

// Some steps from the begin, where most wheels may still be on rigid rails: they cost the same.
void check_track(const par::Comm& comm, const Model& model) {
  Together whole(comm, model);
  Built built(whole.track, whole.line);
  introduce(comm, model, whole, built);
  constexpr int tried = 50;
  const std::int64_t steps = steps_of(whole.track, built);
  const Watch::time_point begin = Watch::now();
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
