// One agreement covers errors on any rank, signals, the wall-time limit and log lines, and costs
// one reduction. Errors of one rank are raised there: until then the rank continues, so that no
// rank waits in a collective call for one that has left.
#include "app/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/deck/deck_files.hpp"
#include "app/run/result_folder.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/model/interrupt.hpp"

namespace trackbed::app {

namespace {

// Of wall time, for schemes that do not agree in every window: far below the second within which a
// request to stop is obeyed, and far above the time of a message.
constexpr double seconds_between_agreements = 0.1;

// A disk that fills up while a checkpoint is written must not destroy the one before.
constexpr std::size_t periodic_checkpoints_kept = 2;

}  // namespace

Run::Run(model::RunContext& context, model::Scheme& scheme)
    : context_(context),
      scheme_(scheme),
      progress_(context, scheme),
      files_(contents_of_files(context.comm, model::effective_deck(context.model))) {}

void Run::add_state_warnings(const std::vector<std::string>& warnings) {
  course_.warnings.insert(course_.warnings.end(), warnings.begin(), warnings.end());
}

Outcome Run::execute() {
  try {
    const Outcome outcome = run_stages();
    context_.log.timer_table(context_.timers);
    return outcome;
  } catch (const RunError& error) {
    std::string state = scheme_.rescue();
    if (!state.empty()) state += "; ";
    note_warnings();
    progress_.note("end", {{"outcome", "failed"}, {"message", error.what()}});
    throw RunError(fmt::format("{} (at {:.6g} s, stage \"{}\"); {}{}", error.what(),
                               course_.clock.time(), scheme_.stage(), state,
                               what_is_left(last_checkpoint_, started_from_, context_.folder)));
  } catch (const std::exception& error) {  // of one rank, such as a lack of memory
    progress_.note("end", {{"outcome", "failed"}, {"message", error.what()}});
    throw;
  }
}

std::vector<std::string> Run::warnings() const {
  std::vector<std::string> all = deck_warnings_;
  all.insert(all.end(), course_.warnings.begin(), course_.warnings.end());
  return all;
}

void Run::note_warnings() {
  const std::vector<std::string> all = warnings();
  for (; warnings_noted_ < all.size(); ++warnings_noted_)
    progress_.note("warning", {{"message", all[warnings_noted_]}});
}

// A resumed run enters a stage that has begun, and so skips `begin_stage`; nothing else differs.
// Output, log line and checkpoint of a window come after the agreement, since they are collective;
// the checkpoint comes last, so that a resumed run repeats none of them.
Outcome Run::run_stages() {
  model::catch_interrupts();
  progress_.begin(last_checkpoint_.empty() ? started_from_ : last_checkpoint_);
  note_warnings();
  mark_unfinished(context_.comm, context_.folder);
  scheme_.start();
  context_.log.mark(course_.clock.time());
  agreed_ = course_.windows, agreed_at_ = context_.log.wall_time();
  while (course_.stage < scheme_.stages()) {
    if (!course_.begun && !begin_stage()) return stop();
    bool stops = false;
    bool more = runs();
    while (more) {
      scheme_.advance();
      const Verdict verdict = agree();
      scheme_.record();
      if (verdict == Verdict::report || verdict == Verdict::report_and_save) report();
      stops = verdict == Verdict::stop;
      more = runs();
      // After the last window of a stage with a checkpoint of its own no other one is written, not
      // even for a stop: results at its end need contacts that a checkpoint does not contain.
      if (!more && scheme_.keeps_stages()) break;
      if (stops) return stop_with_checkpoint();
      if (verdict == Verdict::save || verdict == Verdict::report_and_save ||
          context_.ends(context_.model.output.checkpoint_interval))
        periodic_checkpoint();
    }
    end_stage();
    if (stops && course_.stage < scheme_.stages()) return stop();
  }
  return finish();
}

// False if the run is to stop before the stage has begun: there is nothing to store.
bool Run::begin_stage() {
  course_.begun = scheme_.begin_stage();
  if (course_.begun) progress_.note("stage");
  return course_.begun;
}

void Run::report() {
  const model::Status status = scheme_.status();
  const model::Pace pace = context_.log.progress(course_.clock.time(), time_left(), status.words);
  nlohmann::ordered_json line{{"speed", pace.speed}, {"remaining_s", pace.left}};
  line.update(status.figures);
  progress_.note("progress", line);
  note_warnings();
}

// Called again for the same window by a run that is resumed there.
bool Run::runs() const { return course_.clock.runs() && !scheme_.is_done(); }

double Run::time_left() const {
  const auto windows = static_cast<double>(course_.clock.windows() - course_.clock.window());
  return windows * course_.clock.dt() + scheme_.duration_of_later_stages();
}

// The checkpoint contains the state after the end of the stage: a run resumed from it begins with
// the next one.
void Run::end_stage() {
  scheme_.end_stage();
  course_.begun = false;
  if (scheme_.keeps_stages()) checkpoint("stage_" + scheme_.stage() + ".h5");
  ++course_.stage;
}

Outcome Run::stop_with_checkpoint() {
  checkpoint(name_of_checkpoint());
  return stop();
}

Outcome Run::stop() {
  write_summary(Outcome::stopped);
  note_warnings();
  progress_.note("end", {{"outcome", "stopped"}});
  return Outcome::stopped;
}

Outcome Run::finish() {
  // After the loop the number is one beyond the last stage.
  course_.stage = scheme_.stages() - 1;
  for (const std::string& warning : scheme_.warnings_at_end()) context_.warn(warning);
  // What follows takes long for large results: a run that is killed then is complete.
  write_summary(Outcome::finished);
  scheme_.finish();
  write_summary(Outcome::finished);
  note_warnings();
  progress_.note("end", {{"outcome", "finished"}});
  return Outcome::finished;
}

bool Run::is_at_given_stop() const {
  const std::int64_t given = context_.model.output.stop_after;
  return given > 0 && course_.windows == given;
}

// Wherever the state is stored, and where the stage ends, all ranks must know that it is good.
bool Run::must_agree() const {
  return scheme_.agrees_in_every_window() || course_.windows >= next_agreement_ ||
         is_at_given_stop() || context_.ends(context_.model.output.checkpoint_interval) ||
         !course_.clock.runs();
}

Run::Verdict Run::agree() {
  if (!must_agree()) return Verdict::go_on;
  const auto timing = context_.timers.scope(Phase::agreement);
  const std::string problem = scheme_.problem();
  // Ordered by priority, so that the maximum over ranks decides: errors before all others.
  Verdict mine = Verdict::go_on;
  if (context_.comm.root() && context_.log.due()) mine = Verdict::report;
  if (context_.comm.root() && is_long_without_checkpoint())
    mine = mine == Verdict::report ? Verdict::report_and_save : Verdict::save;
  if (context_.is_to_stop() || is_at_given_stop()) mine = Verdict::stop;
  if (!problem.empty()) mine = Verdict::trouble;
  const auto verdict = static_cast<Verdict>(context_.comm.max(static_cast<std::int64_t>(mine)));
  // The text is exchanged only in this case; throws on every rank.
  if (verdict == Verdict::trouble) context_.comm.agree(problem);
  if (!scheme_.agrees_in_every_window()) plan_next_agreement();
  return verdict;
}

// The same on all ranks: from the windows that the slowest of them computed since the last time.
void Run::plan_next_agreement() {
  const double now = context_.log.wall_time();
  const double each = context_.comm.max(now - agreed_at_) /
                      static_cast<double>(std::max<std::int64_t>(1, course_.windows - agreed_));
  const double most = seconds_between_agreements / std::max(each, 1e-9);
  agreed_ = course_.windows, agreed_at_ = now;
  next_agreement_ = agreed_ + std::max<std::int64_t>(1, std::llround(most));
}

bool Run::is_long_without_checkpoint() const {
  const double interval = context_.model.output.checkpoint_wall_interval;
  return interval > 0 && context_.log.wall_time() - checkpoint_at_ > interval;
}

// Those of a run before it was resumed are not known here and remain.
void Run::periodic_checkpoint() {
  checkpoint(name_of_checkpoint());
  periodic_checkpoints_.push_back(last_checkpoint_);
  if (periodic_checkpoints_.size() <= periodic_checkpoints_kept) return;
  std::error_code ignored;
  if (context_.comm.root()) std::filesystem::remove(periodic_checkpoints_.front(), ignored);
  periodic_checkpoints_.erase(periodic_checkpoints_.begin());
}

std::string Run::name_of_checkpoint() const {
  return fmt::format("checkpoint_{:010d}.h5", course_.windows);
}

}  // namespace trackbed::app
