// Formatting of errors. The message contains the line breaks, so that callers that print what()
// show one problem per line.
#include "trackbed/core/error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <cstdlib>

namespace trackbed {

namespace {

// All problems in one text, so that a deck can be corrected in one pass. There is no line feed at
// the end.
std::string joined(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

}  // namespace

// The base class is initialised first: it reads the list before the list is moved.
InputError::InputError(std::vector<std::string> problems)
    : std::runtime_error(joined(problems)), problems_(std::move(problems)) {}

// abort, not an exception: the state is no longer reliable, so nothing may be written from it, and
// under MPI the launcher ends the other ranks as soon as one is ended by a signal. stdio is used
// because nothing may fail or allocate here.
void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "trackbed: error of the program, please report it: broken invariant: %s\n",
               what);
  std::abort();
}

}  // namespace trackbed
