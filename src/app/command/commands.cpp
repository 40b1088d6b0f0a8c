// The commands of the program. All commands but `describe` and `schema` are collective.
//
// A command reads and checks all its input before it makes or removes anything: a refused run
// leaves the disk as it was. Answers and warnings go to stdout, since warnings are part of the
// answer; problems are exceptions, which program.cpp catches.
#include "app/command/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/command/command_parts.hpp"
#include "app/restart/compatible.hpp"
#include "app/restart/continuation.hpp"
#include "app/restart/spent.hpp"
#include "app/restart/track_resume.hpp"
#include "app/run/progress.hpp"
#include "app/run/result_folder.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/io/replace.hpp"
#include "trackbed/model/batch_job.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

// The checkpoint to start from, or empty. One that does not fit the deck is refused before anything
// is made or removed.
std::string checked_start(const model::Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.start.empty()) return "";
  const par::Comm& comm = warnings.comm;
  const std::string start = checkpoint_meant(comm, model.start, io::IfDamaged::refuse, warnings);
  const io::File file = io::open_checkpoint(comm, start);
  require_same_model(comm, file, start, model, deck);
  warnings.add(spent_changes(comm, file, start, model, deck, Continuation::in_another));
  warnings.add(changed_springs(file, start, model::effective_deck(model), deck));
  return start;
}

// Warns of a cell with other contact stiffnesses or stones; `require_stones` checks all other
// conditions.
void look_at_cell(const model::Model& model, const input::Deck& deck, Warnings& warnings) {
  if (model.bed.cell.empty()) return;
  const par::Comm& comm = warnings.comm;
  const std::string cell = io::choose_checkpoint(comm, model.bed.cell, io::IfDamaged::refuse).file;
  const io::File file = io::open_checkpoint(comm, cell);
  const std::string effective = model::effective_deck(model);
  warnings.add(changed_springs(file, cell, effective, deck));
  if (!model.has_stage(model::StageKind::cribs))
    warnings.add(changed_stones(file, cell, effective, deck));
}

// Of a finished run only the passage of a track can become longer.
int continue_run(const par::Comm& comm, const std::string& folder, const model::Model& model,
                 const input::Deck& deck) {
  Arguments arguments;
  arguments.file = folder;
  arguments.overrides = overrides_of_same_run(comm, folder, model);
  const auto lengthens = [](const std::string& word) {
    return word.starts_with("passage.duration=");
  };
  if (is_finished_in(comm, folder)) {
    std::erase_if(arguments.overrides, [&](const auto& word) { return !lengthens(word); });
    if (arguments.overrides.empty()) {
      print(comm, folder + ": the run is already finished\n");
      return static_cast<int>(ExitCode::success);
    }
  } else if (const std::string key = "output.stop_after";
             model.output.stop_after > 0 && deck.where(key).starts_with("command line")) {
    std::erase_if(arguments.overrides,
                  [&](const auto& word) { return word.starts_with(key + "="); });
    arguments.overrides.push_back(fmt::format("{}={}", key, model.output.stop_after));
  }
  return resume(comm, arguments);
}

void require_readable(const par::Comm& comm, const std::string& path) {
  std::string problem;
  if (comm.root()) {
    std::error_code error;
    if (!fs::exists(path, error))
      problem = error ? fmt::format("{}: cannot be read ({})", path, error.message())
                      : path + ": does not exist";
  }
  problem = comm.broadcast(problem);
  if (!problem.empty()) throw InputError({problem});
}

// If `path` names one. A picture that cannot be written is a failure of the command.
void draw(const par::Comm& comm, const std::string& path, const model::Model& model,
          const std::vector<bed::PlacedShape>& shapes, const std::string& deck) {
  if (path.empty()) return;
  io::replace_file_on_root(comm, path, [&](const std::string& part) {
    std::ofstream file(part);
    file << model::drawing_of(model, shapes, deck);
    if (!file.flush()) throw RunError(path + " cannot be written: " + std::strerror(errno));
  });
  print(comm, "drawing: " + path + "\n");
}

}  // namespace

// Without -o the folder has the name of the deck file.
int run(const par::Comm& comm, const Arguments& arguments) {
  model::require_time_of_job();
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm}, origin{comm};
  const model::Model model = read_model(deck, warnings);
  const std::string folder = arguments.folder.empty()
                                 ? "results/" + fs::path(arguments.deck).stem().string()
                                 : arguments.folder;
  if (arguments.or_resume && has_begun(comm, folder))
    return continue_run(comm, folder, model, deck);
  if (!model.has_stages()) require_files(model.track);
  const std::string start = checked_start(model, deck, origin);
  checked_ground(model, deck, warnings);
  try_options(comm, model);
  const model::StonesToPlace to_place = model::require_placed(comm, model, deck);
  warnings.add(to_place.warnings);
  if (model.has_stages())
    warnings.add(model::warnings_of(model, model::require_stones(comm, model, deck)));
  look_at_cell(model, deck, origin);
  look_at_profiles(model, warnings);
  // Another job may have begun it in the meantime.
  if (arguments.or_resume) {
    if (has_begun(comm, folder)) return continue_run(comm, folder, model, deck);
    require_of_same_run(comm, folder, model);
  }
  // After all checks and before the model is built: a refused run removes nothing, and a folder
  // that cannot be made is reported at once.
  const FolderLock lock = prepare_folder(
      comm, folder,
      arguments.force || arguments.or_resume ? OldResults::remove : OldResults::refuse,
      {start, model.bed.cell});
  draw(comm, folder + "/model.svg", model, to_place.shapes, arguments.deck);
  model::RunContext context(comm, model, deck, arguments.deck, folder);
  const std::unique_ptr<model::Scheme> scheme = model::make_scheme(context, to_place.shapes);
  Run run(context, *scheme);
  run.add_deck_warnings(warnings.sentences);
  if (!start.empty()) run.start_from(start);
  run.add_state_warnings(origin.sentences);
  return finish(run, context);
}

namespace {

void require_svg(const std::string& path) {
  if (!path.empty() && !path.ends_with(".svg"))
    throw InputError(
        {fmt::format("--draw {}: drawings are SVG files; give a name that ends in "
                     ".svg",
                     path)});
}

void print_valid(const par::Comm& comm, const model::Model& model, const input::Deck& deck,
                 const std::string& name) {
  if (const std::string words = model::words_of_defaults(model, deck); !words.empty())
    print(comm, words + "\n");
  print(comm, name + " is valid\n");
}

}  // namespace

int check(const par::Comm& comm, const Arguments& arguments) {
  require_svg(arguments.drawing);
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm};
  const model::Model model = read_model(deck, warnings);
  const bool copies = !model.bed.cell.empty() && model.start.empty();
  if (!arguments.ranks.empty() && (!copies || comm.size() > 1))
    throw InputError(
        {"--ranks: needs a deck whose stones are copies of a cell (bed.cell) and not of a "
         "checkpoint (start), and one rank: other stones have no places before the run"});
  if (!model.has_stages()) {
    if (const model::GroundFile ground = checked_ground(model, deck, warnings);
        !ground.size.empty())
      print(comm, ground.size + "\n");
    model::check_track(comm, model);  // takes steps, and so uses the options of the ground
    warn_of_unused_options(comm, fem::Petsc::unused_options());
    draw(comm, arguments.drawing, model, {}, arguments.deck);
    print_valid(comm, model, deck, arguments.deck);
    return static_cast<int>(ExitCode::success);
  }
  const std::string start = checked_start(model, deck, warnings);
  const model::GroundFile ground = checked_ground(model, deck, warnings);
  warn_of_unused_options(comm, try_options(comm, model));
  const model::StonesToPlace to_place = model::require_placed(comm, model, deck);
  warnings.add(to_place.warnings);
  const model::StonesOfLayers stones = model::require_stones(comm, model, deck);
  warnings.add(model::warnings_of(model, stones));
  look_at_cell(model, deck, warnings);
  look_at_profiles(model, warnings);
  model::check_stages(
      comm, model, {deck, arguments.deck, start, ground.size, to_place, stones, arguments.ranks});
  draw(comm, arguments.drawing, model, to_place.shapes, arguments.deck);
  print_valid(comm, model, deck, arguments.deck);
  return static_cast<int>(ExitCode::success);
}

// Of a model with all defaults. Local.
int describe(const par::Comm& comm, const Arguments& arguments) {
  model::Model model;
  print(comm, input::describe(model::declaration_of(model), arguments.section));
  return static_cast<int>(ExitCode::success);
}

// For editors that complete and check a deck while it is typed.
int schema(const par::Comm& comm, const Arguments&) {
  model::Model model;
  print(comm, input::schema(model::declaration_of(model)));
  return static_cast<int>(ExitCode::success);
}

int kernel(const par::Comm& comm, const Arguments& arguments) {
  const input::Deck deck = input::Deck::read(comm, arguments.deck, arguments.overrides);
  Warnings warnings{comm};
  const model::Model model = read_model(deck, warnings);
  print(comm, model::write_kernel(comm, model, arguments.kernel, arguments.folder) + "\n");
  return static_cast<int>(ExitCode::success);
}

// Opening a checkpoint verifies its seal and all checksums, so an answer also means that the file
// is undamaged. Of results only attributes are read.
int info(const par::Comm& comm, const Arguments& arguments) {
  require_readable(comm, arguments.file);
  std::error_code ignored;
  if (fs::is_directory(arguments.file, ignored)) {
    const std::string words = comm.broadcast(comm.root() ? describe_progress(arguments.file) : "");
    print(comm, words);
    // A run that has written no checkpoint yet.
    if (!words.empty() && !is_there(comm, arguments.file + "/latest"))
      return static_cast<int>(ExitCode::success);
  }
  const bool results = fs::path(arguments.file).filename() == "results.h5";
  Warnings warnings{comm};
  const std::string path =
      results ? arguments.file
              : checkpoint_meant(comm, arguments.file, io::IfDamaged::refuse, warnings);
  const io::File file =
      results ? observe::open_results(comm, path) : io::open_checkpoint(comm, path);
  print(comm, fmt::format("{}: {}, written by trackbed {}\n", path,
                          file.text_attribute("/", "kind"), file.text_attribute("/", "version")));
  if (file.has_attribute("/", "build"))
    print(comm, fmt::format("  {}\n", file.text_attribute("/", "build")));
  if (results) {
    print(comm, fmt::format("  ranks {}\n", file.integer_attribute("/", "ranks")));
    if (file.has("history/time"))
      print(comm, fmt::format("  history rows {}\n", file.extent("history/time").at(0)));
  } else {
    print(comm,
          fmt::format("  format {}\n  deck {}\n  time {:.9g} s\n  stage {} ({})\n"
                      "{}",
                      file.integer_attribute("/", "format"), file.text_attribute("/", "deck_name"),
                      file.number_attribute("/", "time"), file.text_attribute("/", "stage"),
                      file.integer_attribute("/", "stage_finished") ? "finished" : "unfinished",
                      file.has("particles")
                          ? fmt::format("  particles {}\n", file.extent("particles/id").at(0))
                          : ""));
  }
  for (const std::string& name : file.names("/")) print(comm, "  /" + name + "\n");
  return static_cast<int>(ExitCode::success);
}

}  // namespace trackbed::app
