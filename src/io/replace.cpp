// A rename within a folder replaces the old name atomically (POSIX).
#include "trackbed/io/replace.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

namespace trackbed::io {

namespace {

namespace fs = std::filesystem;

// Flushes a file or folder to the disk. Returns the error, or nothing.
std::string synced(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) return path.string() + ": cannot be opened (" + std::strerror(errno) + ")";
  // Some file systems cannot sync a folder and return EINVAL.
  const bool ok = ::fsync(descriptor) == 0 || errno == EINVAL;
  const std::string problem =
      ok ? "" : path.string() + ": cannot be written to the disk (" + std::strerror(errno) + ")";
  ::close(descriptor);
  return problem;
}

}  // namespace

// fsync before the rename: without it the new name may refer to an empty file after a crash of the
// machine. The folder after it: the name itself is data of the folder.
std::string put_in_place(const fs::path& from, const fs::path& to) {
  if (std::string problem = synced(from); !problem.empty()) return problem;
  std::error_code error;
  fs::rename(from, to, error);
  if (error)
    return to.string() + ": cannot be replaced by " + from.string() + " (" + error.message() + ")";
  return synced(to.has_parent_path() ? to.parent_path() : fs::path("."));
}

// After any failure the part is removed, since it may have filled the disk.
void replace_file(const par::Comm& comm, const std::string& path,
                  const std::function<void(const std::string& part)>& write) {
  const std::string part = path + ".part";
  std::error_code ignored;
  try {
    write(part);
    comm.agree(comm.root() ? put_in_place(part, path) : "");
  } catch (...) {
    if (comm.root()) fs::remove(part, ignored);
    throw;
  }
}

// Errors of files that one rank opens alone begin with the rank, as that of the agreement does.
void replace_file_on_root(const par::Comm& comm, const std::string& path,
                          const std::function<void(const std::string& part)>& write) {
  constexpr std::string_view own = "rank 0: ";
  replace_file(comm, path, [&](const std::string& part) {
    std::string problem;
    if (comm.root()) try {
        write(part);
      } catch (const std::exception& error) {
        problem = error.what();
        if (problem.starts_with(own)) problem.erase(0, own.size());
      }
    comm.agree(problem);
  });
}

}  // namespace trackbed::io
