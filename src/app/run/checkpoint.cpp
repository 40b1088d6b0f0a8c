// Checkpoints of a run: attributes that `trackbed info` and `resume` read, the course (group run),
// and what the scheme writes. The layout is described in docs/checkpoint.md.
#include "trackbed/io/checkpoint.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "app/deck/deck_files.hpp"
#include "app/deck/deck_values.hpp"
#include "app/restart/compatible.hpp"
#include "app/run/result_folder.hpp"
#include "app/run/run.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::app {

// "results/mine/", "results/mine" and "results/mine/stage_fill.h5" mean the same folder. The
// checkpoint itself need not exist.
std::string folder_of_checkpoint(const std::string& checkpoint) {
  namespace fs = std::filesystem;
  fs::path folder(checkpoint);
  if (!folder.has_filename()) folder = folder.parent_path();
  if (!fs::is_directory(folder)) folder = folder.parent_path();
  return folder.empty() ? "." : folder.string();
}

// Histories are written first: a checkpoint must not count rows that are not in the file yet. Its
// name is written to `latest` once the file is complete.
void Run::checkpoint(const std::string& name) {
  const auto timing = context_.timers.scope(Phase::output);
  const double begin = context_.log.wall_time();
  scheme_.flush();
  io::write_checkpoint(context_.comm, context_.folder, name, [&](io::File& file) { save(file); });
  last_checkpoint_ = context_.folder + "/" + name;
  checkpoint_at_ = context_.log.wall_time();
  // Twice: a disk that many jobs share may be slower next time.
  context_.reserve = std::max(context_.reserve, 60 + 2 * (checkpoint_at_ - begin));
  progress_.note("checkpoint", {{"file", name}});
}

// The whole input with its defaults is stored: `resume` needs no deck, and later versions with
// other defaults continue the run as this one would.
void Run::save(io::File& file) {
  file.attribute("/", "version", model::version());
  file.attribute("/", "build", model::build_description());
  file.attribute("/", "deck", model::effective_deck(context_.model));
  if (!files_.empty()) file.attribute("/", "files", files_);
  file.attribute("/", "deck_name", context_.name);
  file.attribute("/", "stage", scheme_.stage());
  file.attribute("/", "stage_finished", static_cast<std::int64_t>(!course_.begun));
  file.attribute("/", "time", course_.clock.time());
  io::Archive archive = io::Archive::writer(context_.comm, file);
  model::Course course = course_;
  course.earlier_wall_time += context_.log.wall_time();
  archive.part("run", course);
  scheme_.archive(archive);
}

void Run::load(const io::File& file) {
  course_ = model::course_in(file);
  io::Archive archive = io::Archive::reader(file);
  scheme_.archive(archive);
}

// Partly written files of a killed run are removed: they are as large as the finished files. The
// deck in the results is that of the whole run; changes of it are reported here.
void Run::resume(const std::string& checkpoint) {
  const par::Comm& comm = context_.comm;
  remove_parts(comm, context_.folder);
  const io::File file = io::open_checkpoint(comm, checkpoint);
  load(file);
  last_checkpoint_ = checkpoint;
  const std::string effective = model::effective_deck(context_.model);
  const Values then =
      with_moved_files(comm, file, stored_values(file, values_of(effective)), effective);
  for (const std::string& change : changes(then, values_of(effective)))
    context_.warn(fmt::format("{} from {:.6g} s on, where the run was resumed", change,
                              course_.clock.time()));
  scheme_.resume(file, folder_of_checkpoint(checkpoint) + "/results.h5");
  // The checkpoint was written at the end of a stage: the run continues with the next one.
  if (!course_.begun) ++course_.stage;
  model::say(comm,
             fmt::format("  continues at {:.6g} s from {}", course_.clock.time(), checkpoint));
}

// This is another run than the one that wrote the file: windows and wall time count from 0, and
// results begin again. The simulated time continues, so that histories of both runs can be joined.
void Run::start_from(const std::string& checkpoint) {
  const io::File file = io::open_checkpoint(context_.comm, checkpoint);
  load(file);
  course_.windows = 0, course_.earlier_wall_time = 0;
  course_.stage = stage_after(file, checkpoint, context_.model, context_.deck);
  started_from_ = checkpoint;
}

}  // namespace trackbed::app
