// Two kinds of trouble a user can meet, and the exit code each ends with. Broken invariants of the
// program itself are neither: they abort with rank and values (see `require`).
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

// Trouble while the run is under way (lost particle, not a number, overlap, divergence, disk).
// Thrown on every rank at the same place: see par::Comm::agree.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Aborts the whole MPI job with `what` if `holds` is false: an invariant of the program is broken.
void require(bool holds, const char* what);

}  // namespace trackbed
