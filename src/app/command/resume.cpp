// The command that continues a run from a checkpoint: which parameters may change, whether the run
// is unfinished, and where its results are written.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "app/command/command_parts.hpp"
#include "app/command/commands.hpp"
#include "app/restart/compatible.hpp"
#include "app/restart/spent.hpp"
#include "app/restart/track_resume.hpp"
#include "app/run/result_folder.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/batch_job.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

// The value that stopped the run is in its deck and does not mean to stop again. Collective.
void require_later_stop(const io::File& checkpoint, const model::Model& model,
                        const input::Deck& deck) {
  const std::int64_t done = model::course_in(checkpoint).windows, stop = model.output.stop_after;
  const std::string key = deck.where("output.stop_after");
  if (stop > 0 && stop <= done && key.starts_with("command line"))
    throw InputError(
        {fmt::format("{} = {}: the run has already computed {} windows since its start; give a "
                     "larger number, or 0 for no limit",
                     key, stop, done)});
}

// Refuses changes of parameters that have no effect on the rest of the run. All problems are
// reported together, as for decks. Collective.
void require_can_go_on(const par::Comm& comm, const io::File& file, const std::string& checkpoint,
                       const model::Model& model, const input::Deck& deck) {
  require_same_model(comm, file, checkpoint, model, deck);
  std::vector<std::string> problems =
      spent_changes(comm, file, checkpoint, model, deck, Continuation::within_the_run);
  // The start of the run itself is in its deck.
  if (const std::string place = deck.where("start"); place.starts_with("command line"))
    problems.push_back(fmt::format(
        "{} has no effect: the run continues from {}; leave it out, or use trackbed run", place,
        checkpoint));
  if (!problems.empty()) throw InputError(problems);
}

// After the end of the last stage a run is finished, unless it was killed before it wrote its
// summary. Collective: rank 0 reads it.
bool run_is_finished(const par::Comm& comm, const io::File& checkpoint, const model::Model& model,
                     const std::string& folder) {
  if (checkpoint.integer_attribute("/", "stage_finished") == 0 ||
      checkpoint.text_attribute("/", "stage") != model.stages.back().name)
    return false;
  const bool reported = comm.root() && is_finished(folder);
  return !comm.broadcast(reported ? "reported" : "").empty();
}

// A run that continues from an older checkpoint in its own folder replaces later results, which
// needs
// --force. Collective: rank 0 reads the folder.
void require_newest(const par::Comm& comm, const std::string& checkpoint,
                    const std::string& folder) {
  std::string newest;
  if (comm.root()) std::getline(std::ifstream(folder + "/latest") >> std::ws, newest);
  newest = comm.broadcast(newest);
  if (newest.empty() || newest == fs::path(checkpoint).filename()) return;
  throw InputError({fmt::format(
      "{}: is not the newest checkpoint of the run in {} (the newest is {}): this run would "
      "replace all later results; give -o DIR to keep them, or --force to replace them",
      checkpoint, folder, newest)});
}

// Results of another run have other columns: of another model, or other rows of tables ([[stage]]).
// Other values may differ, by overrides of a resume.
void require_same_parts(const io::File& results, const std::string& path, const io::File& file) {
  const Values of_results = values_of(results.text_attribute("/", "deck"));
  for (const auto& [key, value] : values_of(file.text_attribute("/", "deck"))) {
    const auto found = of_results.find(key);
    const bool row = key.find('[') != key.npos;
    if (found == of_results.end() ? row : key == "model" && found->second != value)
      throw InputError(
          {fmt::format("{}: belongs to another run, whose deck does not have {} = {}; restore the "
                       "results of this run, or move the file away",
                       path, key, value)});
  }
}

// Damaged histories are refused: the run would replace them. If they do not exist the run continues
// with a warning. Collective.
void look_for_histories(const io::File& file, const std::string& checkpoint, Warnings& warnings) {
  const std::string results = folder_of_checkpoint(checkpoint) + "/results.h5";
  const std::int64_t rows = model::history_rows_in(file);
  if (!observe::has_histories(warnings.comm, results, rows))
    warnings.add(
        {fmt::format("{}: does not exist; the histories begin at the time of the checkpoint, "
                     "{:.6g} s, and earlier rows are lost",
                     results, file.number_attribute("/", "time"))});
  else if (rows > 0)
    require_same_parts(observe::open_results(warnings.comm, results), results, file);
}

// Whether a run of stages is unfinished. All problems are found before the folder is changed.
// Collective.
bool stages_left(const std::string& checkpoint, const model::Model& model, const input::Deck& deck,
                 const Arguments& arguments, Warnings& warnings) {
  const par::Comm& comm = warnings.comm;
  const io::File file = io::open_checkpoint(comm, checkpoint);
  require_can_go_on(comm, file, checkpoint, model, deck);
  require_later_stop(file, model, deck);
  const std::string own = folder_of_checkpoint(checkpoint);
  if (!run_is_finished(comm, file, model, own)) {
    look_for_histories(file, checkpoint, warnings);
    return true;
  }
  if (!arguments.overrides.empty())
    throw InputError(
        {fmt::format("{}: the run is finished, so that these changes have no effect: {}; leave "
                     "them out, or run the deck with them in another folder (-o DIR)",
                     checkpoint, fmt::join(arguments.overrides, " "))});
  return false;
}

// The same of a passage.
bool passage_left(const std::string& checkpoint, const model::Model& model, const input::Deck& deck,
                  const Warnings& warnings) {
  const bool left = is_track_left(warnings.comm, checkpoint, model, deck);
  require_later_stop(io::open_checkpoint(warnings.comm, checkpoint), model, deck);
  return left;
}

// The folder of the checkpoint, and the folder in which the run continues.
struct Place {
  std::string own, folder;
  bool at_home;
};

Place place_of(const par::Comm& comm, const Arguments& arguments) {
  const std::string own = folder_of_checkpoint(arguments.file);
  const std::string folder = arguments.folder.empty() ? own : arguments.folder;
  return {own, folder, same_folder(comm, own, folder)};
}

// Locked before anything else: a run that still writes here removes checkpoints. A folder without
// `latest` is not a result folder, and no lock file is made in it.
std::optional<FolderLock> lock_of(const par::Comm& comm, const Place& place) {
  std::optional<FolderLock> lock;
  if (place.at_home &&
      !comm.broadcast(fs::exists(fs::path(place.own) / "latest") ? "there" : "").empty())
    lock.emplace(comm, place.folder);
  return lock;
}

// Read and closed: the file must not stay open while new checkpoints may replace it.
struct StoredDeck {
  std::string deck, name;
};
StoredDeck stored_in(const par::Comm& comm, const std::string& checkpoint) {
  const io::File file = io::open_checkpoint(comm, checkpoint);
  return {file.text_attribute("/", "deck"), file.text_attribute("/", "deck_name")};
}

// If a newer checkpoint is damaged, the run may have reached its limit of windows before: it does
// not stop there again, unless this command gives a limit.
std::vector<std::string> without_stop(std::vector<std::string> overrides) {
  const std::string key = "output.stop_after=";
  if (std::none_of(overrides.begin(), overrides.end(),
                   [&](const std::string& word) { return word.starts_with(key); }))
    overrides.push_back(key + "0");
  return overrides;
}

}  // namespace

// The deck is stored in the checkpoint; overrides may change what later windows use. A damaged
// newest checkpoint is passed over with a warning, and the one before is used. A start from a
// checkpoint refuses a damaged one instead, since there the user chose a definite state.
int resume(const par::Comm& comm, const Arguments& arguments) {
  model::require_time_of_job();
  require_track_checkpoint(comm, arguments.file);
  const Place place = place_of(comm, arguments);
  std::optional<FolderLock> lock = lock_of(comm, place);
  Warnings warnings{comm}, origin{comm};
  const std::string checkpoint =
      checkpoint_meant(comm, arguments.file, io::IfDamaged::pass_over, origin);
  const StoredDeck stored = stored_in(comm, checkpoint);
  const input::Deck deck = input::Deck::stored(
      stored.deck, "input stored in " + checkpoint,
      origin.sentences.empty() ? arguments.overrides : without_stop(arguments.overrides));
  const model::Model model = read_model(deck, warnings);
  // In another folder the last part of a finished track alone is computed again.
  const bool left = model.has_stages()
                        ? stages_left(checkpoint, model, deck, arguments, origin)
                        : passage_left(checkpoint, model, deck, warnings) || !place.at_home;
  if (!left) {
    print(comm, checkpoint + ": the run is already finished\n");
    return static_cast<int>(ExitCode::success);
  }
  if (place.at_home && !arguments.force && !fs::is_directory(arguments.file))
    require_newest(comm, checkpoint, place.own);
  // The files are those with which the run began.
  checked_ground(model, deck, warnings);
  try_options(comm, model);
  look_at_profiles(model, warnings);
  // Results beside the checkpoint are those of this run; any other folder is prepared as for `run`.
  if (!place.at_home)
    lock.emplace(prepare_folder(comm, place.folder,
                                arguments.force ? OldResults::remove : OldResults::refuse,
                                {checkpoint}));
  else if (!lock)
    lock.emplace(comm, place.folder);
  model::RunContext context(comm, model, deck, stored.name, place.folder);
  const std::unique_ptr<model::Scheme> scheme = model::make_scheme(context, {});
  Run run(context, *scheme);
  run.add_deck_warnings(warnings.sentences);
  run.resume(checkpoint);
  run.add_state_warnings(origin.sentences);
  return finish(run, context);
}

}  // namespace trackbed::app
