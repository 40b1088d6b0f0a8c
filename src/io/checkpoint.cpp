// How a checkpoint stays consistent:
//   write `name.part`, each dataset with a checksum, and seal its structure (seal.hpp) -> close ->
//   open again, compare -> fsync -> rename -> fsync the folder -> the same for the text file
//   `latest`, whose first line names the newest.
// A reader therefore sees either the old file or the new one (replace.cpp). Cost: the file is read
// back once, from the cache of the system.
#include "trackbed/io/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/handle.hpp"
#include "io/seal.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/replace.hpp"

namespace trackbed::io {

namespace {

namespace fs = std::filesystem;
constexpr const char* kind = "trackbed checkpoint";

[[noreturn]] void refuse(const std::string& sentence) { throw InputError({sentence}); }

// The checkpoints that the text file `latest` names, newest first.
std::vector<std::string> listed_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::ifstream in(folder / "latest");
  for (std::string name; std::getline(in, name);)
    if (!name.empty()) names.push_back(name);
  return names;
}

// The last step, so that the first entry of `latest` is always a complete file. Earlier checkpoints
// follow, as their order cannot be derived from the files: copies have other dates. On rank 0.
std::string write_latest(const fs::path& folder, const std::string& name) {
  const fs::path part = folder / "latest.part";
  std::ofstream out(part);
  out << name << '\n';
  std::error_code ignored;
  for (const std::string& before : listed_in(folder))
    if (before != name && fs::exists(folder / before, ignored)) out << before << '\n';
  out.close();
  if (!out) return part.string() + ": cannot be written";
  return put_in_place(part, folder / "latest");
}

// Throws the message about a damaged or foreign file on all ranks. Collective. Cost: each rank
// reads its fraction of the file once.
void verify(const File& file, const std::string& path) {
  // All ranks must make the same collective calls: whether there is a kind is agreed on first.
  if (file.handle().comm.max(std::int64_t{file.has_attribute("/", "kind") ? 0 : 1}) != 0 ||
      file.text_attribute("/", "kind") != kind)
    refuse(path + ": is not a trackbed checkpoint");
  const std::int64_t format = file.integer_attribute("/", "format");
  if (format != checkpoint_format)
    refuse(fmt::format(
        "{}: was written by {} version of trackbed (checkpoint format {}; this version reads "
        "format {}); use that version, or run the deck again",
        path, format > checkpoint_format ? "a newer" : "an older", format, checkpoint_format));
  // All numbers are read and checked, each rank its fraction, before they are used.
  for (const std::string& dataset : datasets_of(file))
    if (!file.has_attribute(dataset, checksum_name) ||
        stored_hash(file.handle(), dataset) !=
            static_cast<std::uint64_t>(file.integer_attribute(dataset, checksum_name)))
      refuse(path + ": is damaged: dataset " + dataset +
             " does not match its checksum; an earlier checkpoint of the run may be intact");
}

// Why `path` is not a complete file, or nothing. Without HDF5, see seal.hpp. On rank 0.
std::string absence_or_defect(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return path + ": does not exist";
  if (!fs::is_regular_file(path, ignored)) return path + ": is not a file";
  const std::string damage = defect_of(path);
  return damage.empty() ? "" : path + ": " + damage;
}

// The folder may contain other files: a file that has neither a name given by runs nor the seal of
// a checkpoint is ignored without a message.
bool is_ours(const fs::path& file) {
  const std::string name = file.filename().string();
  if (file.extension() != ".h5" || name == "results.h5") return false;
  return name.starts_with("checkpoint_") || name.starts_with("stage_") ||
         defect_of(file.string()).empty();
}

// All checkpoints of the folder, the newest first: those that `latest` names in its order, then
// others by time of writing, which copies change. Equal times (coarse file systems) are ordered by
// name, so that the choice is always the same.
std::vector<std::string> newest_first(const fs::path& folder) {
  struct Found {
    std::ptrdiff_t place;
    fs::file_time_type time;
    std::string name;
  };
  const std::vector<std::string> listed = listed_in(folder);
  std::vector<Found> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (is_ours(entry.path()))
      found.push_back({std::find(listed.begin(), listed.end(), name) - listed.begin(),
                       entry.last_write_time(ignored), name});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    if (a.place != b.place) return a.place < b.place;
    return a.time != b.time ? a.time > b.time : a.name > b.name;
  });
  std::vector<std::string> names;
  for (const Found& one : found) names.push_back(one.name);
  return names;
}

// Checkpoints that `path` may refer to, best first, one path per line; on rank 0. The first one in
// `latest` comes first even if it does not exist: this is then reported.
std::string candidates(const std::string& path, IfDamaged if_damaged) {
  std::error_code ignored;
  // The text file `latest` stands for the folder whose newest checkpoint it names.
  const bool names_latest = fs::path(path).filename() == "latest" && fs::is_regular_file(path);
  if (!names_latest && !fs::is_directory(path, ignored)) return path + "\n";
  const fs::path folder = names_latest ? fs::path(path).parent_path() : fs::path(path);
  const std::vector<std::string> listed = listed_in(folder);
  const std::string latest = listed.empty() ? "" : listed.front();
  std::string lines = latest.empty() ? "" : (folder / latest).string() + "\n";
  if (if_damaged == IfDamaged::refuse) return lines;
  for (const std::string& name : newest_first(folder))
    if (name != latest) lines += (folder / name).string() + "\n";
  return lines;
}

// `fill` may have failed before the end: the file is closed by its destructor before it is removed.
// Collective. The seal is written by rank 0 after HDF5 has closed the file.
void write_part(const par::Comm& comm, const std::string& part,
                const std::function<void(File&)>& fill) {
  File file(comm, part, Mode::create);
  file.attribute("/", "kind", std::string(kind));
  file.attribute("/", "format", checkpoint_format);
  file.attribute("/", "trackbed_version", std::string(TRACKBED_VERSION));
  fill(file);
  const std::vector<Extent> extents = extents_of(file);
  file.close();
  comm.agree(comm.root() ? seal(part, extents) : "");
}

// A write that reported success does not prove that the data are correct. Errors are detected
// before the old checkpoint is given up. Collective.
void read_back(const par::Comm& comm, const std::string& part) {
  const std::string damage = comm.root() ? defect_of(part) : "";
  comm.agree(damage.empty()
                 ? ""
                 : part + ": " + damage +
                       " (found when the file was read back after writing; check the disk)");
  try {
    verify(File(comm, part, Mode::read), part);
  } catch (const InputError& error) {  // the same on all ranks: detected in collective reads
    throw RunError(std::string(error.what()) +
                   " (found when the file was read back after writing; check the disk)");
  }
}

}  // namespace

// Before the rename no existing file is changed.
void write_checkpoint(const par::Comm& comm, const std::string& folder, const std::string& name,
                      const std::function<void(File&)>& fill) {
  std::error_code error;
  if (comm.root()) fs::create_directories(folder, error);
  comm.agree(error ? folder + ": cannot be created (" + error.message() + ")" : "");
  const fs::path target = fs::path(folder) / name;
  const std::string part = target.string() + ".part";
  try {
    write_part(comm, part, fill);
    read_back(comm, part);
    // Only `.part` was written: the last checkpoint and `latest` are unchanged.
  } catch (const RunError&) {
    if (comm.root()) fs::remove(part, error);
    comm.barrier();
    throw;
  }
  std::string problem;
  if (comm.root()) {
    problem = put_in_place(part, target);
    if (problem.empty()) problem = write_latest(folder, name);
  }
  comm.agree(problem);
}

// RunError becomes InputError here: an unreadable file was named by the user.
File open_checkpoint(const par::Comm& comm, const std::string& file_name) {
  const std::string problem = comm.broadcast(comm.root() ? absence_or_defect(file_name) : "");
  if (!problem.empty()) refuse(problem);
  try {
    File file(comm, file_name, Mode::read);
    verify(file, file_name);
    return file;
  } catch (const RunError& error) {  // "rank 0: <file>: ...": the rank is omitted
    const std::string text = error.what();
    const std::size_t start = text.find(file_name);
    refuse(file_name + ": is damaged" +
           (start == std::string::npos ? "" : text.substr(start + file_name.size())));
  }
}

// Collective: rank 0 makes the list and all ranks open each file in turn, so that all choose the
// same one.
CheckpointChoice choose_checkpoint(const par::Comm& comm, const std::string& path,
                                   IfDamaged if_damaged) {
  CheckpointChoice chosen;
  const std::string lines = comm.broadcast(comm.root() ? candidates(path, if_damaged) : "");
  if (lines.empty())
    refuse(path + ": contains no checkpoint; give the result folder of a run, or a file .h5 in it");
  std::istringstream paths(lines);
  while (std::getline(paths, chosen.file)) {
    if (if_damaged == IfDamaged::refuse) return chosen;  // open_checkpoint reports the defect
    try {
      open_checkpoint(comm, chosen.file);
      return chosen;
    } catch (const InputError& error) {  // equal on all ranks
      chosen.passed_over.emplace_back(error.what());
    }
  }
  throw InputError(chosen.passed_over);
}

}  // namespace trackbed::io
