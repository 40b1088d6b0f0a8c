// Sentences are sorted by line, because declarations are visited in another order than people read.
#include "input/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <climits>

#include "trackbed/core/error.hpp"

namespace trackbed::input {

std::string Problems::start(const Node* place) const {
  if (place != nullptr && place->commanded) return "command line: ";
  if (place != nullptr && place->line > 0) return fmt::format("{}:{}: ", origin_, place->line);
  return fmt::format("{}: ", origin_);
}

void Problems::add(const Node* place, const std::string& sentence) {
  int order = INT_MAX - 1;
  if (place != nullptr && place->line > 0) order = place->line;
  if (place != nullptr && place->commanded) order = INT_MAX;
  list_.push_back({order, start(place) + sentence});
}

void Problems::throw_if_any() const {
  if (list_.empty()) return;
  std::vector<Problem> sorted = list_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return a.order < b.order; });
  std::vector<std::string> sentences;
  for (const Problem& problem : sorted) sentences.push_back(problem.sentence);
  throw InputError(std::move(sentences));
}

}  // namespace trackbed::input
