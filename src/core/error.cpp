#include "trackbed/core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace trackbed {

namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    if (!text.empty()) text += '\n';
    text += line;
  }
  return text;
}

}  // namespace

InputError::InputError(std::vector<std::string> problems)
    : std::runtime_error(joined(problems)), problems_(std::move(problems)) {}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "trackbed: broken invariant: %s\n", what);
  std::abort();
}

}  // namespace trackbed
