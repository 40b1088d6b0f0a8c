// The commands of the program. All commands but `describe` and `schema` are collective.
//
// A command reads and checks all its input before it makes or removes anything: a refused run
// leaves the disk as it was. Answers and warnings go to stdout, since warnings are part of the
// answer; problems are exceptions, which program.cpp catches.
#include "app/command/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/check/estimate.hpp"
#include "app/check/placed_check.hpp"
#include "app/command/command_parts.hpp"
#include "app/parameters/version.hpp"
#include "app/restart/compatible.hpp"
#include "app/restart/spent.hpp"
#include "app/run/result_folder.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/io/checkpoint.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

// The checkpoint to start from, or empty. One that does not fit the deck is refused before anything
// is made or removed.
std::string checked_start(const Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.start.empty()) return "";
  const par::Comm& comm = warnings.comm;
  const std::string start = checkpoint_meant(comm, model.start, io::IfDamaged::refuse, warnings);
  const io::File file = io::open_checkpoint(comm, start);
  require_same_model(comm, file, start, effective_deck(model), deck);
  warnings.add(spent_changes(comm, file, start, model, deck, Continuation::in_another));
  warnings.add(changed_springs(file, start, effective_deck(model), deck));
  return start;
}

// Warns of changed contact stiffnesses of a cell; `require_stones` checks all other conditions.
void look_at_cell(const Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.bed.cell.empty()) return;
  const par::Comm& comm = warnings.comm;
  const std::string cell = io::choose_checkpoint(comm, model.bed.cell, io::IfDamaged::refuse).file;
  warnings.add(changed_springs(io::open_checkpoint(comm, cell), cell, effective_deck(model), deck));
}

}  // namespace

std::string version() { return TRACKBED_VERSION; }

// Includes what the run started from: a result states its origin, and a resumed run may begin with
// any stage. The files themselves are not read again.
std::string effective_deck(const Model& model) {
  Model copy = model;  // `declare` is not const; here it changes no value
  return input::effective(declaration_of(copy));
}

// Without -o the folder has the name of the deck file.
int run(const par::Comm& comm, const Arguments& arguments) {
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm}, origin{comm};
  const Model model = read_model(deck, warnings);
  const std::string folder = arguments.folder.empty()
                                 ? "results/" + fs::path(arguments.deck).stem().string()
                                 : arguments.folder;
  const bool alone = !model.has_stages();
  if (alone) require_files(model.track);
  const std::string start = checked_start(model, deck, origin);
  checked_ground(model, deck, warnings);
  try_options(comm, model);
  const StonesToPlace to_place = require_placed(comm, model, deck);
  warnings.add(to_place.warnings);
  if (model.has_stages()) warnings.add(warnings_of(model, require_stones(comm, model, deck)));
  look_at_cell(model, deck, origin);
  look_at_profiles(model, warnings);
  // After all checks and before the model is built: a refused run removes nothing, and a folder
  // that cannot be made is reported at once.
  const FolderLock lock =
      prepare_folder(comm, folder, arguments.force ? OldResults::remove : OldResults::refuse,
                     start.empty() ? model.bed.cell : start);
  if (alone)
    return run_alone(comm, model,
                     {.deck = arguments.deck,
                      .effective = effective_deck(model),
                      .folder = folder,
                      .warnings = warnings.sentences});
  Simulation simulation(comm, model, deck, arguments.deck, folder);
  simulation.keep(warnings.sentences);
  simulation.give_shapes(to_place.shapes);
  if (!start.empty()) simulation.start_from(start);
  simulation.keep_in_state(origin.sentences);
  return finish(comm, simulation, folder);
}

// Builds the model as far as possible without moving it. The bed is filled, since the number of
// stones and their smallest mass are known only then. Memory is that after the first fill; contacts
// add to it later.
int check(const par::Comm& comm, const Arguments& arguments) {
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm};
  const Model model = read_model(deck, warnings);
  if (!model.has_stages()) {
    if (const GroundFile ground = checked_ground(model, deck, warnings); !ground.size.empty())
      print(comm, ground.size + "\n");
    warn_of_unused_options(comm, try_options(comm, model));
    check_track(comm, model);
    print(comm, arguments.deck + " is valid\n");
    return static_cast<int>(ExitCode::success);
  }
  const std::string start = checked_start(model, deck, warnings);
  const GroundFile ground = checked_ground(model, deck, warnings);
  warn_of_unused_options(comm, try_options(comm, model));
  const StonesToPlace to_place = require_placed(comm, model, deck);
  warnings.add(to_place.warnings);
  const StonesOfLayers stones = require_stones(comm, model, deck);
  warnings.add(warnings_of(model, stones));
  look_at_cell(model, deck, warnings);
  look_at_profiles(model, warnings);
  World world(comm, model);
  if (world.placement) world.placement->give_shapes(to_place.shapes);
  StageActions actions(world, model);
  Progress progress(comm);
  progress.start(world, model, arguments.deck);
  if (!ground.size.empty()) print(comm, ground.size + "\n");
  // After a start from a checkpoint the remaining work depends on stones that only a run loads.
  if (!model.has_stones()) {
    for (const std::string& line : estimate_alone(world)) print(comm, line + "\n");
  } else if (model.is_placed()) {
    for (const std::string& line : estimate_placed(world, deck)) print(comm, line + "\n");
  } else if (start.empty() && model.stages.front().kind == StageKind::fill) {
    actions.begin(model.stages.front());
    const dem::Totals totals = world.particles.totals();
    const bool more = std::count_if(model.stages.begin(), model.stages.end(),
                                    [](const Stage& s) { return s.kind == StageKind::fill; }) > 1;
    print(comm,
          fmt::format("  stones{}: {} of {} pieces, {:.0f} kg\n", more ? " of the first layer" : "",
                      totals.particles, totals.pieces, totals.mass));
    for (const std::string& line : estimate(world, actions, stones, deck)) print(comm, line + "\n");
  } else {
    print(comm, "  stones: as in " + start + "\n");
  }
  const auto megabytes = static_cast<double>(world.memory()) / (1024 * 1024);
  print(comm, fmt::format("memory: at most {:.2g} MB of state per rank\n", comm.max(megabytes)));
  print(comm, arguments.deck + " is valid\n");
  return static_cast<int>(ExitCode::success);
}

// Of a model with all defaults. Local.
int describe(const par::Comm& comm, const Arguments& arguments) {
  Model model;
  print(comm, input::describe(declaration_of(model), arguments.section));
  return static_cast<int>(ExitCode::success);
}

// For editors that complete and check a deck while it is typed.
int schema(const par::Comm& comm, const Arguments&) {
  Model model;
  print(comm, input::schema(declaration_of(model)));
  return static_cast<int>(ExitCode::success);
}

// Opening a checkpoint verifies its seal and all checksums, so an answer also means that the file
// is undamaged. Of results only attributes are read.
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
                      file.integer_attribute("/", "stage_finished") ? "finished" : "unfinished",
                      file.integer_attribute("/", "particles")));
  }
  for (const std::string& name : file.names("/")) print(comm, "  /" + name + "\n");
  return static_cast<int>(ExitCode::success);
}

}  // namespace trackbed::app
