// What each word of the command line does. All commands but `describe` and `schema` are collective.
//
// A command reads everything it is told, checks it, and only then makes or removes anything: a
// refused run leaves the disk as it was. Answers go to stdout, warnings with them, since they are
// part of the answer; problems leave as exceptions and end in program.cpp.
#include "app/commands.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "app/compatible.hpp"
#include "app/estimate.hpp"
#include "app/result_folder.hpp"
#include "app/rules.hpp"
#include "app/simulation.hpp"
#include "app/spent.hpp"
#include "app/track_rules.hpp"
#include "app/track_run.hpp"
#include "app/version.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/io/checkpoint.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

input::Declaration declaration_of(Model& model) {
  return [&model](input::Section& section) { model.declare(section); };
}

// Flushed at once: batch systems show stdout to users only when it is flushed, and a run that is
// killed must have said where it was.
void print(const par::Comm& comm, const std::string& text) {
  if (!comm.root()) return;
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

// Warnings before a run begins: said at once, and kept for its summary. All ranks have the same.
struct Warnings {
  const par::Comm& comm;
  std::vector<std::string> said = {};
  void add(const std::vector<std::string>& sentences) {
    for (const std::string& sentence : sentences) {
      print(comm, fmt::format("warning: {}\n", sentence));
      said.push_back(sentence);
    }
  }
};

// Warnings are said and the run goes on; problems leave as InputError.
// Collective; each rank parses alike and so has the same sentences.
Model read_model(const input::Deck& deck, Warnings& warnings) {
  Model model;
  warnings.add(deck.fill(declaration_of(model)));
  return model;
}

// The exit code tells a script whether to run `resume`; the sentence tells a person.
int finish(const par::Comm& comm, Simulation& simulation, const std::string& folder) {
  const Outcome outcome = simulation.run();
  for (const std::string& option : fem::Petsc::unused_options())
    if (option != "no_signal_handler")
      print(comm,
            fmt::format("warning: the PETSc option -{} was asked for by nothing (those of the "
                        "ground begin with -ground_)\n",
                        option));
  if (outcome == Outcome::finished) {
    print(comm, "results: " + folder + "\n");
    return static_cast<int>(ExitCode::success);
  }
  print(comm, "stopped early; go on with: trackbed resume " + folder + "\n");
  return static_cast<int>(ExitCode::stopped);
}

// The file that a checkpoint's name or its folder's means; one that is passed over is worth a word.
std::string checkpoint_meant(const par::Comm& comm, const std::string& path,
                             io::IfDamaged if_damaged, Warnings& warnings) {
  const io::Chosen chosen = io::choose_checkpoint(comm, path, if_damaged);
  warnings.add(chosen.passed_over);
  if (!chosen.passed_over.empty()) print(comm, fmt::format("going on from {}\n", chosen.file));
  return chosen.file;
}

// What one rank alone cannot read is told on all of them: the others would wait for it.
GroundFile ground_of_all(const par::Comm& comm, const Model& model, const input::Deck& deck) {
  GroundFile file;
  std::string problem;
  try {
    file = require_ground(model, deck);
  } catch (const InputError& error) {
    problem = error.what();
  }
  if (const std::string first = comm.first_problem(problem); !first.empty())
    throw InputError({first});
  return file;
}

// Collective.
GroundFile checked_ground(const Model& model, const input::Deck& deck, Warnings& warnings) {
  GroundFile file = ground_of_all(warnings.comm, model, deck);
  warnings.add(file.warnings);
  return file;
}

int run_alone(const par::Comm& comm, const Model& model, const TrackRunOf& of) {
  return static_cast<int>(run_track(comm, model, of) ? ExitCode::success : ExitCode::stopped);
}

// Of the rail of a train and of loads on a bed; a track alone has read them when it is built.
void look_at_profiles(const Model& model, Warnings& warnings) {
  if (!model.has_stages()) return;
  if (model.has_train()) warnings.add(doubts_of_files(model.track));
  warnings.add(doubts_of_loads(model));
}

// The checkpoint to start from, or nothing. One that does not fit the deck is refused before
// anything is made or removed.
std::string checked_start(const Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.start.empty()) return "";
  const par::Comm& comm = warnings.comm;
  const std::string start = checkpoint_meant(comm, model.start, io::IfDamaged::refuse, warnings);
  const io::File file = io::open_checkpoint(comm, start);
  require_same_model(comm, file, start, effective_deck(model), deck);
  warnings.add(spent_changes(comm, file, start, model, deck, GoesOn::in_another));
  warnings.add(changed_springs(file, start, effective_deck(model), deck));
  return start;
}

// Of the cell that a bed is made of; what else must fit is looked at by `require_stones`.
void look_at_cell(const Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.bed.cell.empty()) return;
  const par::Comm& comm = warnings.comm;
  const std::string cell = io::choose_checkpoint(comm, model.bed.cell, io::IfDamaged::refuse).file;
  warnings.add(changed_springs(io::open_checkpoint(comm, cell), cell, effective_deck(model), deck));
}

}  // namespace

std::string version() { return TRACKBED_VERSION; }

// With what the run began from: a result tells where it comes from, and a resumed run may begin
// with any stage. The files themselves are not looked for again.
std::string effective_deck(const Model& model) {
  Model copy = model;  // declaring fills, here with what is there already
  return input::effective(declaration_of(copy));
}

// Without -o the folder has the name of the deck's file.
int run(const par::Comm& comm, const Arguments& arguments) {
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm};
  const Model model = read_model(deck, warnings);
  const std::string folder = arguments.folder.empty()
                                 ? "results/" + fs::path(arguments.deck).stem().string()
                                 : arguments.folder;
  const bool alone = !model.has_stages();
  if (alone) require_files(model.track);
  const std::string start = checked_start(model, deck, warnings);
  checked_ground(model, deck, warnings);
  if (!alone) require_stones(comm, model, deck);
  look_at_cell(model, deck, warnings);
  look_at_profiles(model, warnings);
  // After all checks and before the model is built: a refused run has removed nothing, and a folder
  // that cannot be made costs no time.
  const FolderLock lock =
      prepare_folder(comm, folder, arguments.force ? OldResults::remove : OldResults::refuse,
                     start.empty() ? model.bed.cell : start);
  if (alone)
    return run_alone(comm, model,
                     {.deck = arguments.deck,
                      .effective = effective_deck(model),
                      .folder = folder,
                      .warnings = warnings.said});
  Simulation simulation(comm, model, deck, arguments.deck, folder);
  simulation.keep(warnings.said);
  if (!start.empty()) simulation.start_from(start);
  return finish(comm, simulation, folder);
}

// Nothing is resumed with a parameter that means nothing to it.
// All problems in one list, as with decks. Collective.
void require_can_go_on(const par::Comm& comm, const io::File& file, const std::string& checkpoint,
                       const Model& model, const input::Deck& deck) {
  require_same_model(comm, file, checkpoint, effective_deck(model), deck);
  std::vector<std::string> problems =
      spent_changes(comm, file, checkpoint, model, deck, GoesOn::within_the_run);
  const std::int64_t done = file.read_all<std::int64_t>("run/counts").at(4);
  const std::string key = deck.where("output.stop_after");
  // The one that stopped the run stands in its deck and is no wish to stop again.
  if (model.output.stop_after > 0 && model.output.stop_after <= done &&
      key.starts_with("command line"))
    problems.push_back(
        fmt::format("{} = {} windows of the whole run: {} are done already; give "
                    "more, or 0",
                    key, model.output.stop_after, done));
  // The one of the run itself stands in its deck.
  if (const std::string place = deck.where("start"); place.starts_with("command line"))
    problems.push_back(fmt::format("{} has no effect: the run goes on from {}", place, checkpoint));
  if (!problems.empty()) throw InputError(problems);
}

// After the end of the last stage there is nothing to go on with. A run that was killed right then
// has not told its figures yet. Collective: rank 0 looks.
bool is_finished(const par::Comm& comm, const io::File& checkpoint, const Model& model,
                 const std::string& folder) {
  if (checkpoint.integer_attribute("/", "stage_finished") == 0 ||
      checkpoint.text_attribute("/", "stage") != model.stages.back().name)
    return false;
  std::stringstream summary;
  if (comm.root()) summary << std::ifstream(folder + "/summary.json").rdbuf();
  const bool told = summary.str().find("\"finished\": true") != std::string::npos;
  return !comm.broadcast(told ? "told" : "").empty();
}

// A run that goes on from an older checkpoint in its own folder replaces what came after it: only
// if that is said. Collective: rank 0 looks.
void require_newest(const par::Comm& comm, const std::string& checkpoint,
                    const std::string& folder) {
  std::string newest;
  if (comm.root()) std::getline(std::ifstream(folder + "/latest") >> std::ws, newest);
  newest = comm.broadcast(newest);
  if (newest.empty() || newest == fs::path(checkpoint).filename()) return;
  throw InputError({fmt::format(
      "{}: is not the newest checkpoint of the run in {}, which is {}: results after it would be "
      "replaced; give -o DIR to keep them, or --force",
      checkpoint, folder, newest)});
}

// Damaged histories are refused: the run would replace them. Those that are not there were taken
// away, so the run goes on without, and says so. Collective.
void look_for_histories(const io::File& file, const std::string& checkpoint, Warnings& warnings) {
  const std::string results = folder_of_checkpoint(checkpoint) + "/results.h5";
  const std::int64_t rows = file.read_all<std::int64_t>("run/counts").at(5);
  if (!observe::has_histories(warnings.comm, results, rows))
    warnings.add(
        {fmt::format("{}: does not exist; histories begin anew at the checkpoint, "
                     "at {:.6g} s, those before it are lost",
                     results, file.number_attribute("/", "time"))});
}

// Whether there is something left to do for a run of stages. All problems are found before the
// folder is touched. Collective.
bool stages_left(const std::string& checkpoint, const Model& model, const input::Deck& deck,
                 const Arguments& arguments, Warnings& warnings) {
  const par::Comm& comm = warnings.comm;
  const io::File file = io::open_checkpoint(comm, checkpoint);
  require_can_go_on(comm, file, checkpoint, model, deck);
  const std::string own = folder_of_checkpoint(checkpoint);
  if (!is_finished(comm, file, model, own)) {
    look_for_histories(file, checkpoint, warnings);
    return true;
  }
  if (!arguments.overrides.empty())
    throw InputError({fmt::format("{}: the run is finished: {} can change nothing", checkpoint,
                                  fmt::join(arguments.overrides, " "))});
  return false;
}

// The deck comes from the checkpoint; overrides may change what later windows use.
// A damaged newest checkpoint is passed over, with a warning: the one before is worth more than no
// run. A start from a checkpoint refuses instead, since there the user named one state and means
// it.
int resume(const par::Comm& comm, const Arguments& arguments) {
  require_track_checkpoint(comm, arguments.file);
  const std::string own = folder_of_checkpoint(arguments.file);
  const std::string folder = arguments.folder.empty() ? own : arguments.folder;
  const bool at_home = same_folder(comm, own, folder);
  // First of all: a run that still writes here takes checkpoints away. A folder without `latest` is
  // none of ours, and nothing is left in it.
  std::optional<FolderLock> lock;
  if (at_home && !comm.broadcast(fs::exists(fs::path(own) / "latest") ? "there" : "").empty())
    lock.emplace(comm, folder);
  Warnings warnings{comm};
  const std::string checkpoint =
      checkpoint_meant(comm, arguments.file, io::IfDamaged::pass_over, warnings);
  std::string text, name;
  {
    const io::File file = io::open_checkpoint(comm, checkpoint);
    text = file.text_attribute("/", "deck");
    name = file.text_attribute("/", "deck_name");
  }
  const input::Deck deck =
      input::Deck::stored(text, "input stored in " + checkpoint, arguments.overrides);
  const Model model = read_model(deck, warnings);
  const bool alone = !model.has_stages();
  look_at_profiles(model, warnings);
  // In another folder the end of a track alone is worth doing again.
  const bool left =
      alone ? is_track_left(comm, checkpoint, model.track, effective_deck(model), deck) || !at_home
            : stages_left(checkpoint, model, deck, arguments, warnings);
  if (!left) {
    print(comm, checkpoint + ": the run is finished; nothing is left to do\n");
    return static_cast<int>(ExitCode::success);
  }
  if (at_home && !arguments.force && !fs::is_directory(arguments.file))
    require_newest(comm, checkpoint, own);
  // Closed by now: the file must not stay open while new checkpoints may replace it.
  // Results beside the checkpoint are those of this run; any other folder is as new to it as to
  // run.
  if (!at_home)
    lock.emplace(prepare_folder(
        comm, folder, arguments.force ? OldResults::remove : OldResults::refuse, checkpoint));
  else if (!lock)
    lock.emplace(comm, folder);
  if (alone)
    return run_alone(comm, model,
                     {.deck = name,
                      .effective = effective_deck(model),
                      .folder = folder,
                      .checkpoint = checkpoint,
                      .warnings = warnings.said});
  Simulation simulation(comm, model, deck, name, folder);
  simulation.keep(warnings.said);
  simulation.resume(checkpoint);
  return finish(comm, simulation, folder);
}

// Builds the model as far as it can be without moving it.
// Fills the bed, since only stones know their smallest mass and number. Memory is that after the
// first fill; contacts come later and add to it.
int check(const par::Comm& comm, const Arguments& arguments) {
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm};
  const Model model = read_model(deck, warnings);
  if (!model.has_stages()) {
    if (const GroundFile ground = checked_ground(model, deck, warnings); !ground.size.empty())
      print(comm, ground.size + "\n");
    check_track(comm, model);
    print(comm, arguments.deck + " is valid\n");
    return static_cast<int>(ExitCode::success);
  }
  if (model.ground.present) fem::Petsc::try_options(comm, model.dimension);
  const std::string start = checked_start(model, deck, warnings);
  const GroundFile ground = checked_ground(model, deck, warnings);
  const StonesOfLayers stones = require_stones(comm, model, deck);
  look_at_cell(model, deck, warnings);
  look_at_profiles(model, warnings);
  World world(comm, model);
  StageActions actions(world, model);
  Progress progress(comm);
  progress.start(world, model, arguments.deck);
  if (!ground.size.empty()) print(comm, ground.size + "\n");
  // What is left to do after a start hangs on stones that only a run loads.
  if (start.empty() && model.stages.front().kind == StageKind::fill) {
    actions.begin(model.stages.front());
    const dem::Totals totals = world.particles.totals();
    const bool more = std::count_if(model.stages.begin(), model.stages.end(),
                                    [](const Stage& s) { return s.kind == StageKind::fill; }) > 1;
    print(comm,
          fmt::format("  stones{}: {} of {} pieces, {:.0f} kg\n", more ? " of the first layer" : "",
                      totals.particles, totals.pieces, totals.mass));
    for (const std::string& line : estimate(world, actions, stones, deck)) print(comm, line + "\n");
  } else {
    print(comm, "  stones: those of " + start + "\n");
  }
  const auto megabytes = static_cast<double>(world.memory()) / (1024 * 1024);
  print(comm, fmt::format("memory: {:.0f} MB of state on the fullest rank\n", comm.max(megabytes)));
  print(comm, arguments.deck + " is valid\n");
  return static_cast<int>(ExitCode::success);
}

// Of a model with all defaults, on any rank alone.
int describe(const par::Comm& comm, const Arguments& arguments) {
  Model model;
  print(comm, input::describe(declaration_of(model), arguments.section));
  return static_cast<int>(ExitCode::success);
}

// For editors: a deck is then completed and checked while it is typed.
int schema(const par::Comm& comm, const Arguments&) {
  Model model;
  print(comm, input::schema(declaration_of(model)));
  return static_cast<int>(ExitCode::success);
}

// Opening a checkpoint compares its seal and all checksums, so an answer also says that the file is
// whole. Of results only attributes are read.
int info(const par::Comm& comm, const Arguments& arguments) {
  if (!fs::exists(arguments.file)) throw InputError({arguments.file + ": does not exist"});
  const bool results = fs::path(arguments.file).filename() == "results.h5";
  Warnings warnings{comm};
  const std::string path =
      results ? arguments.file
              : checkpoint_meant(comm, arguments.file, io::IfDamaged::refuse, warnings);
  const io::File file =
      results ? observe::open_results(comm, path) : io::open_checkpoint(comm, path);
  print(comm, fmt::format("{}: {}, written by trackbed {}\n", path,
                          file.text_attribute("/", "kind"), file.text_attribute("/", "version")));
  if (results) {
    print(comm, fmt::format("  ranks {}\n", file.integer_attribute("/", "ranks")));
    if (file.has("history/time"))
      print(comm, fmt::format("  history rows {}\n", file.extent("history/time").at(0)));
  } else {
    print(comm,
          fmt::format("  format {}\n  deck {}\n  time {:.9g} s\n  stage {} ({})\n"
                      "  particles {}\n",
                      file.integer_attribute("/", "format"), file.text_attribute("/", "deck_name"),
                      file.number_attribute("/", "time"), file.text_attribute("/", "stage"),
                      file.integer_attribute("/", "stage_finished") ? "finished" : "under way",
                      file.integer_attribute("/", "particles")));
  }
  for (const std::string& name : file.names("/")) print(comm, "  /" + name + "\n");
  return static_cast<int>(ExitCode::success);
}

}  // namespace trackbed::app
