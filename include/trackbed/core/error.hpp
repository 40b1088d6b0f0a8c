// The two kinds of errors that a user can cause or see, and the exit code of each. Violated
// invariants of the program itself are neither: they abort with a message (see `require`).
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace trackbed {

// stopped: on request (signal, wall-time limit), after writing a checkpoint.
enum class ExitCode { success = 0, bad_input = 2, stopped = 3, run_failed = 4 };

// All problems of an input at once; each is one sentence that starts with `file:line:`.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<std::string> problems);
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

// An error during the run (lost particle, not a number, overlap, divergence, disk). It is raised on
// every rank at the same place: see par::Comm::agree.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Aborts the whole MPI job with `what` if `holds` is false: an invariant of the program is
// violated.
void require(bool holds, const char* what);

}  // namespace trackbed
