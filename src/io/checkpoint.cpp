// How a checkpoint stays whole:
//   write `name.part`, each dataset with a checksum, and seal its structure (seal.hpp) -> close ->
//   open again, compare -> fsync -> rename -> fsync the folder -> the same way for the one-line
//   text file `latest`.
// A rename within a folder replaces the old name at one instant (POSIX), so a reader meets either
// the old file or the new one. Cost: the file is read back once, from the system's cache.
#include "trackbed/io/checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "io/handle.hpp"
#include "io/seal.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::io {

namespace {

namespace fs = std::filesystem;
constexpr const char* kind = "trackbed checkpoint";

[[noreturn]] void refuse(const std::string& sentence) { throw InputError({sentence}); }

// Puts a file or folder onto the disk. Returns what went wrong, or nothing.
std::string synced(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) return path.string() + ": " + std::strerror(errno);
  // Some file systems cannot sync a folder; they say EINVAL.
  const bool ok = ::fsync(descriptor) == 0 || errno == EINVAL;
  const std::string problem = ok ? "" : path.string() + ": " + std::strerror(errno);
  ::close(descriptor);
  return problem;
}

std::string put_in_place(const fs::path& from, const fs::path& to) {
  if (std::string problem = synced(from); !problem.empty()) return problem;
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return to.string() + ": cannot be put in place (" + error.message() + ")";
  return synced(to.parent_path());
}

std::string write_latest(const fs::path& folder, const std::string& name) {
  const fs::path part = folder / "latest.part";
  std::ofstream out(part);
  out << name << '\n';
  out.close();
  if (!out) return part.string() + ": cannot be written";
  return put_in_place(part, folder / "latest");
}

// Throws the sentence about a damaged or foreign file on all ranks.
void verify(const File& file, const std::string& path) {
  if (file.handle().comm.max(std::int64_t{has_attribute(file, "/", "kind") ? 0 : 1}) != 0 ||
      file.text_attribute("/", "kind") != kind)
    refuse(path + ": is not a trackbed checkpoint");
  const std::int64_t format = file.integer_attribute("/", "format");
  if (format > checkpoint_format)
    refuse(path + ": was written by a newer trackbed (checkpoint format " + std::to_string(format) +
           "; this one reads up to " + std::to_string(checkpoint_format) + ")");
  for (const std::string& dataset : datasets_of(file))
    if (!has_attribute(file, dataset, checksum_name) ||
        stored_hash(file.handle(), dataset) !=
            static_cast<std::uint64_t>(file.integer_attribute(dataset, checksum_name)))
      refuse(path + ": is damaged: dataset " + dataset + " does not match its checksum");
}

// The file meant by `path`, on rank 0; sets `problem` if there is none.
std::string resolved(const fs::path& path, std::string& problem) {
  std::error_code ignored;
  fs::path file = path;
  if (fs::is_directory(path, ignored)) {
    std::ifstream in(path / "latest");
    std::string name;
    if (!std::getline(in, name) || name.empty()) {
      problem = (path / "latest").string() + ": does not exist; the folder has no checkpoint";
      return "";
    }
    file = path / name;
  }
  if (!fs::exists(file, ignored))
    problem = file.string() + ": does not exist";
  else if (!fs::is_regular_file(file, ignored))
    problem = file.string() + ": is not a file";
  else if (const std::string damage = why_not_whole(file.string()); !damage.empty())
    problem = file.string() + ": " + damage;
  return file.string();
}

// The one `latest` names comes first, then the newest; on rank 0. Paths, one per line.
std::string candidates(const fs::path& folder) {
  std::string first;
  std::ifstream(folder / "latest") >> first;
  struct Found {
    fs::file_time_type time;
    std::string name;
  };
  std::vector<Found> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".h5" && name != "results.h5" && name != first)
      found.push_back({entry.last_write_time(ignored), name});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return a.time != b.time ? a.time > b.time : a.name > b.name;
  });
  std::string lines = first.empty() ? "" : (folder / first).string() + "\n";
  for (const Found& one : found) lines += (folder / one.name).string() + "\n";
  return lines;
}

// `fill` may have failed half way: the file is closed by its destructor before it is removed.
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

void read_back(const par::Comm& comm, const std::string& part) {
  const std::string damage = comm.root() ? why_not_whole(part) : "";
  comm.agree(damage.empty() ? "" : part + ": " + damage + " right after it was written");
  try {
    verify(File(comm, part, Mode::read), part);
  } catch (const InputError& error) {  // equal on all ranks: found in collective reads
    throw RunError(std::string(error.what()) + " right after it was written");
  }
}

}  // namespace

void write_checkpoint(const par::Comm& comm, const std::string& folder, const std::string& name,
                      const std::function<void(File&)>& fill) {
  std::error_code error;
  if (comm.root()) fs::create_directories(folder, error);
  comm.agree(error ? folder + ": cannot be made (" + error.message() + ")" : "");
  const fs::path target = fs::path(folder) / name;
  const std::string part = target.string() + ".part";
  try {
    write_part(comm, part, fill);
    read_back(comm, part);
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

File open_checkpoint(const par::Comm& comm, const std::string& path) {
  std::string problem, file_name;
  if (comm.root()) file_name = resolved(path, problem);
  problem = comm.broadcast(problem);
  if (!problem.empty()) refuse(problem);
  file_name = comm.broadcast(file_name);
  try {
    File file(comm, file_name, Mode::read);
    verify(file, file_name);
    return file;
  } catch (const RunError& error) {  // "rank 0: <file>: ...": the rank says nothing here
    const std::string text = error.what();
    const std::size_t start = text.find(file_name);
    refuse(file_name + ": is damaged" +
           (start == std::string::npos ? "" : text.substr(start + file_name.size())));
  }
}

Newest newest_good_checkpoint(const par::Comm& comm, const std::string& folder) {
  Newest newest;
  const std::string lines = comm.broadcast(comm.root() ? candidates(folder) : "");
  if (lines.empty()) open_checkpoint(comm, folder);  // throws the sentence about such a folder
  std::istringstream paths(lines);
  while (std::getline(paths, newest.file)) {
    try {
      open_checkpoint(comm, newest.file);
      return newest;
    } catch (const InputError& error) {  // equal on all ranks
      newest.refused.emplace_back(error.what());
    }
  }
  throw InputError(newest.refused);
}

}  // namespace trackbed::io
