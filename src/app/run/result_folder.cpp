// Results are recognised by their names (docs/running.md lists them), so that damaged or partly
// written files are included: a folder must never contain files of two runs.
//
// Files are removed only with --force, only if trackbed writes files of that name, and only in the
// folder itself and its `fields`; notes and scripts of a user remain.
#include "app/run/result_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <vector>

#include "app/restart/track_resume.hpp"
#include "app/run/progress.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/unix_time.hpp"
#include "trackbed/observe/output_parts.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;

// Takes `start` and `end` off `name` if it has both; whether it did.
bool strip(std::string_view& name, std::string_view start, std::string_view end) {
  if (name.size() < start.size() + end.size() || !name.starts_with(start) || !name.ends_with(end))
    return false;
  name.remove_prefix(start.size());
  name.remove_suffix(end.size());
  return true;
}

// A partly written file has the ending .part.
bool is_result(std::string_view name) {
  strip(name, "", ".part");
  if (name == "results.h5" || name == "summary.json" || name == "latest" || name == progress_file)
    return true;
  if (strip(name, "checkpoint_", ".h5"))
    return name.find_first_not_of("0123456789") == std::string_view::npos;
  return strip(name, "stage_", ".h5");
}

// Only the endings are compared: the names begin with names of stages, which the deck chooses.
bool is_picture(std::string_view name) {
  return std::any_of(observe::field_parts.begin(), observe::field_parts.end(), [&](auto part) {
    return name.ends_with(fmt::format("_{}.hdf", part)) ||
           name == fmt::format("{}.hdf.series", part);
  });
}

void collect(const fs::path& folder, bool (*wanted)(std::string_view), std::vector<fs::path>& to) {
  if (!fs::is_directory(folder)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (wanted(entry.path().filename().string()) && entry.is_regular_file())
      to.push_back(entry.path());
}

// Sorted, so that messages do not depend on the file system.
std::vector<fs::path> results_in(const fs::path& folder) {
  std::vector<fs::path> found;
  collect(folder, is_result, found);
  collect(folder / "fields", is_picture, found);
  std::sort(found.begin(), found.end());
  return found;
}

// Paths are compared element by element, so that "run1" is not a prefix of "run10".
bool lies_in(const fs::path& path, const fs::path& folder) {
  const fs::path home = fs::canonical(folder), place = fs::weakly_canonical(path);
  return std::mismatch(home.begin(), home.end(), place.begin(), place.end()).first == home.end();
}

// True also if only a link to the checkpoint is in the folder: the link would be removed. On rank
// 0.
bool start_lies_in(const fs::path& start, const fs::path& folder) {
  if (start.empty() || !fs::is_directory(folder)) return false;
  return lies_in(start, folder) || lies_in(fs::absolute(start).parent_path(), folder);
}

// Why the run is refused, or empty. On rank 0. In this order: not a folder, a start that would be
// removed, existing results. Each sentence names the remedy.
std::string objection(const std::string& folder, const std::vector<fs::path>& old,
                      OldResults old_results, const std::vector<std::string>& origins) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    return fmt::format("{}: is not a folder; choose another name for the result folder (-o DIR)",
                       folder);
  const bool remove = old_results == OldResults::remove;
  for (const std::string& origin : origins)
    if ((remove || !old.empty()) && start_lies_in(origin, folder))
      return fmt::format(
          "{}: contains {}, from which this run starts: results in this folder cannot be replaced; "
          "choose another folder (-o DIR)",
          folder, origin);
  if (remove || old.empty()) return "";
  // A run that is finished, or was killed before its first checkpoint, does not go on.
  const bool goes_on = fs::exists(fs::path(folder) / "latest") && !is_finished(folder);
  return fmt::format(
      "{}: contains results of an earlier run ({}{}); {}choose another folder (-o DIR) or have "
      "them removed (--force)",
      folder, old.front().lexically_relative(folder).string(),
      old.size() > 1 ? fmt::format(" and {} more", old.size() - 1) : "",
      goes_on ? fmt::format("continue that run (trackbed resume {}), ", folder) : "");
}

// Removes files; returns an error message, or empty. Stops at the first failure: the next run is
// refused again because of the remaining files.
std::string removed(const std::vector<fs::path>& files) {
  std::error_code error;
  for (const fs::path& file : files)
    if (!fs::remove(file, error) && error)
      return fmt::format("cannot remove {}: {}", file.string(), error.message());
  return "";
}

// False only if another run holds the lock: without a lock of its file system a run goes on.
bool locked_within(int descriptor, double patience) {
  const double end = unix_time() + patience;
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    if (unix_time() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

}  // namespace

// An InputError and not a RunError: the remedy is another -o.
void make_folder(const par::Comm& comm, const std::string& folder) {
  std::error_code error;
  if (comm.root()) fs::create_directories(folder, error);
  const std::string problem = comm.broadcast(
      error ? fmt::format(
                  "{}: the result folder cannot be created ({}); choose another folder (-o DIR)",
                  folder, error.message())
            : "");
  if (!problem.empty()) throw InputError({problem});
}

bool same_folder(const par::Comm& comm, const std::string& one, const std::string& other) {
  std::error_code error;  // a path that does not exist equals no folder
  const bool same = comm.root() && fs::equivalent(one, other, error) && !error;
  return !comm.broadcast(same ? "same" : "").empty();
}

// `flock` is released with the open file: a remaining lock file never blocks a later run.
// `info` takes the lock for a moment, too.
FolderLock::FolderLock(const par::Comm& comm, const std::string& folder, double patience) {
  std::string problem;
  if (comm.root()) {
    descriptor_ = ::open((folder + "/.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0)
      problem = fmt::format("{}: the folder is not writable ({}); choose another folder (-o DIR)",
                            folder, std::strerror(errno));
    else if (!locked_within(descriptor_, patience))
      problem = fmt::format(
          "{}: another run is writing into this folder; wait until that run ends, stop that run, "
          "or choose another folder (-o DIR)",
          folder);
  }
  problem = comm.broadcast(problem);
  if (problem.empty()) return;
  if (descriptor_ >= 0) ::close(descriptor_);
  throw InputError({problem});
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

// The finished file exists beside its part or will be written again: parts are useless.
void remove_parts(const par::Comm& comm, const std::string& folder) {
  std::string problem;
  if (comm.root()) try {
      std::vector<fs::path> parts;
      collect(
          folder, [](std::string_view name) { return name.ends_with(".part") && is_result(name); },
          parts);
      problem = removed(parts);
    } catch (const fs::filesystem_error& error) {
      problem = fmt::format("{}: cannot be searched: {}", folder, error.what());
    }
  comm.agree(problem);
}

FolderLock prepare_folder(const par::Comm& comm, const std::string& folder, OldResults old_results,
                          const std::vector<std::string>& origins) {
  // Rank 0 reads the folder and broadcasts: file systems may be updated late on other nodes.
  // Nothing is removed before all checks have passed.
  std::vector<fs::path> old;
  std::string problem;
  if (comm.root()) try {
      old = results_in(folder);
      problem = objection(folder, old, old_results, origins);
    } catch (const fs::filesystem_error& error) {
      problem = fmt::format("{}: cannot be searched for results: {}", folder, error.what());
    }
  problem = comm.broadcast(problem);
  if (!problem.empty()) throw InputError({problem});
  make_folder(comm, folder);
  FolderLock lock(comm, folder);
  comm.agree(removed(old));
  return lock;
}

// On rank 0; a full disk may be reported only when the file is closed.
void write_summary_file(const par::Comm& comm, const std::string& folder, const std::string& text) {
  std::string problem;
  if (comm.root()) {
    errno = 0;
    std::ofstream file(folder + "/summary.json");
    file << text << "\n";
    file.close();
    if (!file)
      problem = fmt::format("{}/summary.json: cannot be written ({})", folder,
                            errno != 0 ? std::strerror(errno) : "no reason given");
  }
  comm.agree(problem);
}

void mark_unfinished(const par::Comm& comm, const std::string& folder) {
  std::string text;
  if (comm.root() && is_finished(folder)) {
    auto summary =
        nlohmann::ordered_json::parse(std::ifstream(folder + "/summary.json"), nullptr, false);
    summary["finished"] = false;
    text = summary.dump(2);
  }
  if (!comm.broadcast(text).empty()) write_summary_file(comm, folder, text);
}

std::string resume_command(const std::string& checkpoint, const std::string& folder) {
  const bool within = fs::path(checkpoint).parent_path().lexically_normal() ==
                      (fs::path(folder) / "").parent_path().lexically_normal();
  return "trackbed resume " + checkpoint + (within ? "" : " -o " + folder + " --force");
}

// The sentence also states that there is no checkpoint.
std::string what_is_left(const std::string& last_checkpoint, const std::string& started_from,
                         const std::string& folder) {
  if (last_checkpoint.empty())
    return "no checkpoint was written" +
           (started_from.empty() ? "" : "; the run started from " + started_from);
  return fmt::format("last valid checkpoint: {}; after the cause is removed, continue with: {}",
                     last_checkpoint, resume_command(last_checkpoint, folder));
}

}  // namespace trackbed::app
