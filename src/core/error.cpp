// How trouble becomes text. The line breaks stay in the message, so that whoever prints what()
// shows one problem per line and need not know that there are several.
#include "trackbed/core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace trackbed {

namespace {

// All problems in one text: a deck is mended in one go, not one problem per run. No line feed at
// the end; whoever prints adds what follows.
std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    if (!text.empty()) text += '\n';
    text += line;
  }
  return text;
}

}  // namespace

// The base class comes first: it reads the list before the list is moved away.
InputError::InputError(std::vector<std::string> problems)
    : std::runtime_error(joined(problems)), problems_(std::move(problems)) {}

// abort, not an exception: the state can no longer be trusted, so nothing may be written from it,
// and under MPI the launcher ends the other ranks as soon as one dies by a signal. stdio, because
// nothing here may fail or allocate.
void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "trackbed: broken invariant: %s\n", what);
  std::abort();
}

}  // namespace trackbed
