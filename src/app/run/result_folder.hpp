// The folder a run writes into.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// What a new run does with existing results in its folder.
enum class OldResults { refuse, remove };

// Makes the folder if it does not exist. Throws InputError on all ranks. Collective.
void make_folder(const par::Comm& comm, const std::string& folder);

// Whether both paths are the same existing folder; links are followed. Collective: rank 0 decides
// for ranks with other mounts.
bool same_folder(const par::Comm& comm, const std::string& one, const std::string& other);

// Exclusive lock while a run writes into `folder`: two runs would corrupt the histories. Made by
// the functions below; released with the object, or by the system when the program is killed.
// Throws InputError on all ranks if another run holds it. Collective: rank 0 holds it.
class FolderLock {
 public:
  // `patience`: s, how long it waits for another run to end.
  FolderLock(const par::Comm& comm, const std::string& folder, double patience = 1);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  int descriptor_ = -1;
};

// Makes `folder` if needed and removes results of an earlier run; files that trackbed does not
// write remain. `origins`: the checkpoints that the new run or its deck names (files or their
// folders; an empty text is none). Throws InputError, with everything unchanged, if there are
// results and they are not to be removed, or if an origin is one of them; RunError if a file cannot
// be removed. Collective: rank 0 decides.
FolderLock prepare_folder(const par::Comm& comm, const std::string& folder, OldResults old_results,
                          const std::vector<std::string>& origins);

// Removes partly written results of a killed run in `folder` (NAME.part); to be called while the
// folder is locked. Throws RunError if a file cannot be removed. Collective.
void remove_parts(const par::Comm& comm, const std::string& folder);

// Continues a run with results in `folder` from its checkpoint, which is in another folder if the
// run was resumed from there and has written none.
std::string resume_command(const std::string& checkpoint, const std::string& folder);

// After an error in a run with results in `folder`: how to continue it. Other arguments may be
// empty: no checkpoint, no start from one.
std::string what_is_left(const std::string& last_checkpoint, const std::string& started_from,
                         const std::string& folder);

// The summary of a finished run that goes on (a longer passage) states so until it ends again.
// Collective; throws RunError.
void mark_unfinished(const par::Comm& comm, const std::string& folder);

// Writes the text of summary.json. Collective; throws RunError.
void write_summary_file(const par::Comm& comm, const std::string& folder, const std::string& text);

}  // namespace trackbed::app
