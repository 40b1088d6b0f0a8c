// Messages are sorted by line, because declarations are visited in another order than the deck is
// written in. The sort is stable, so that messages about one line keep the order of the
// declaration.
#include "input/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <climits>

#include "trackbed/core/error.hpp"

namespace trackbed::input {

// Editors and terminals can open "file:line:".
std::string Problems::start(const Node* place) const {
  if (place != nullptr && place->from_override) return "command line: ";
  if (place != nullptr && place->line > 0) return fmt::format("{}:{}: ", origin_, place->line);
  return fmt::format("{}: ", origin_);
}

Problems::Problem Problems::located(const Node* place, const std::string& sentence) const {
  // A missing parameter has no line: it is sorted after the file and before the command line.
  int order = INT_MAX - 1;
  if (place != nullptr && place->line > 0) order = place->line;
  if (place != nullptr && place->from_override) order = INT_MAX;
  return {order, start(place) + sentence};
}

void Problems::add(const Node* place, const std::string& sentence) {
  list_.push_back(located(place, sentence));
}

// Warnings have locations and order like problems, but do not stop the run.
void Problems::warn(const Node* place, const std::string& sentence) {
  warnings_.push_back(located(place, sentence));
}

std::vector<std::string> Problems::sorted(std::vector<Problem> list) {
  std::stable_sort(list.begin(), list.end(),
                   [](const Problem& a, const Problem& b) { return a.order < b.order; });
  std::vector<std::string> sentences;
  for (const Problem& problem : list) sentences.push_back(problem.sentence);
  return sentences;
}

// One exception for all messages, so that a user corrects a deck once.
void Problems::throw_if_any() const {
  if (!list_.empty()) throw InputError(sorted(list_));
}

}  // namespace trackbed::input
