// The folder a run writes into.
#pragma once

#include <string>
#include <utility>

#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// What a new run does about results that lie in its folder.
enum class OldResults { refuse, remove };

// Makes the folder if it is missing. Throws InputError on all ranks. Collective.
void make_folder(const par::Comm& comm, const std::string& folder);

// Whether both paths lead to the same folder that exists; links count as what they lead to.
// Collective: rank 0 looks, so that ranks with other mounts do as it does.
bool same_folder(const par::Comm& comm, const std::string& one, const std::string& other);

// Held while a run writes into `folder`, so that no second one does: two would tear the histories
// apart. Made by the functions below; given up with the object, or by the system when the program
// is killed. Throws InputError on all ranks if another run holds it. Collective: rank 0 holds it.
class FolderLock {
 public:
  FolderLock(const par::Comm& comm, const std::string& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  int descriptor_ = -1;
};

// Leaves `folder` there and without results of an earlier run; files that trackbed does not write
// stay. `start`: the checkpoint the new run begins with (a file or its folder), or empty. Throws
// InputError, with everything as it was, if there are results and they are not to be removed, or if
// `start` is one of them; RunError if a file cannot be removed. Collective: rank 0 looks.
FolderLock prepare_folder(const par::Comm& comm, const std::string& folder, OldResults old_results,
                          const std::string& start);

// Removes what a run that was killed left half written in `folder` (NAME.part of its results); to
// be called while the folder is held. Throws RunError if a file cannot be removed. Collective.
void remove_parts(const par::Comm& comm, const std::string& folder);

// After an error in a run: what to go on with. Empty: no checkpoint, or not from one.
std::string what_is_left(const std::string& last_checkpoint, const std::string& started_from);

// Writes the text of summary.json. Collective; throws RunError.
void write_summary_file(const par::Comm& comm, const std::string& folder, const std::string& text);

}  // namespace trackbed::app
