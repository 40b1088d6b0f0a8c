#include "app/command/command_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/restart/continuation.hpp"
#include "app/restart/track_resume.hpp"
#include "app/run/result_folder.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"

namespace trackbed::app {

namespace {

// A problem of one rank is an exception on all of them: the others would wait for it.
model::GroundFile ground_of_all(const par::Comm& comm, const model::Model& model,
                                const input::Deck& deck) {
  model::GroundFile file;
  std::string problem;
  try {
    file = model::require_ground(model, deck);
  } catch (const InputError& error) {
    problem = error.what();
  }
  if (const std::string first = comm.first_problem(problem); !first.empty())
    throw InputError({first});
  return file;
}

}  // namespace

void warn_of_unused_options(const par::Comm& comm, const std::vector<std::string>& options) {
  for (const std::string& option : options)
    if (option != "no_signal_handler")
      print(comm,
            fmt::format("warning: the PETSc option -{} was set but never used (options of the "
                        "ground begin with -ground_; they are used only if an equation system is "
                        "solved, that is, in implicit steps or for a static equilibrium)\n",
                        option));
}

void Warnings::add(const std::vector<std::string>& more) {
  for (const std::string& sentence : more) {
    print(comm, fmt::format("warning: {}\n", sentence));
    sentences.push_back(sentence);
  }
}

model::Model read_model(const input::Deck& deck, Warnings& warnings) {
  model::Model model;
  warnings.add(deck.fill(model::declaration_of(model)));
  return model;
}

bool is_there(const par::Comm& comm, const std::string& path) {
  std::error_code error;  // what cannot be looked at is not there
  const bool there = comm.root() && std::filesystem::exists(path, error) && !error;
  return !comm.broadcast(there ? "there" : "").empty();
}

bool is_finished_in(const par::Comm& comm, const std::string& folder) {
  const bool finished = comm.root() && is_finished(folder);
  return !comm.broadcast(finished ? "finished" : "").empty();
}

// A run may have been killed between its first checkpoint and the entry in `latest`. Waits for a
// run that still writes there, such as the ranks of a job that a queue has started again.
bool has_begun(const par::Comm& comm, const std::string& folder) {
  if (!is_there(comm, folder)) return false;
  constexpr double patience = 60;  // s
  const FolderLock lock(comm, folder, patience);
  return has_checkpoint(comm, folder) || is_finished_in(comm, folder);
}

int finish(Run& run, const model::RunContext& context) {
  const par::Comm& comm = context.comm;
  const Outcome outcome = run.execute();
  warn_of_unused_options(comm, fem::Petsc::unused_options());
  if (outcome == Outcome::finished) {
    print(comm, "results: " + context.folder + "\n");
    return static_cast<int>(ExitCode::success);
  }
  const std::string& checkpoint = run.last_checkpoint();
  if (checkpoint.empty())
    print(comm, "stopped early, before a checkpoint was written: run the deck again\n");
  else if (checkpoint.starts_with(context.folder + "/"))  // the newest
    print(comm, "stopped early; continue with: trackbed resume " + context.folder + "\n");
  else
    print(comm,
          "stopped early; continue with: " + resume_command(checkpoint, context.folder) + "\n");
  return static_cast<int>(ExitCode::stopped);
}

std::string checkpoint_meant(const par::Comm& comm, const std::string& path,
                             io::IfDamaged if_damaged, Warnings& warnings) {
  const io::CheckpointChoice chosen = io::choose_checkpoint(comm, path, if_damaged);
  warnings.add(chosen.passed_over);
  if (!chosen.passed_over.empty()) print(comm, fmt::format("continuing from {}\n", chosen.file));
  return chosen.file;
}

model::GroundFile checked_ground(const model::Model& model, const input::Deck& deck,
                                 Warnings& warnings) {
  model::GroundFile file = ground_of_all(warnings.comm, model, deck);
  warnings.add(file.warnings);
  return file;
}

std::vector<std::string> try_options(const par::Comm& comm, const model::Model& model) {
  const bool staged = model.has_stages();
  const bool moves = !staged || std::any_of(model.stages.begin(), model.stages.end(),
                                            [](const auto& stage) { return stage.ground_moves; });
  if (!model.ground.present || !moves) return fem::Petsc::unused_options();
  return fem::Petsc::try_options(comm, model.ground, model.dimension, model.domain().thickness,
                                 staged ? model.time.window : model.track.passage.step);
}

void look_at_profiles(const model::Model& model, Warnings& warnings) {
  if (!model.has_stages()) return;
  if (model.has_train()) warnings.add(model::warnings_of_files(model.track));
  warnings.add(model::warnings_of_loads(model));
}

}  // namespace trackbed::app
