// Limits in words, said the same way in messages and in the reference. Private to the room.
#pragma once

#include <fmt/format.h>

#include <string>

#include "input/tree.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::input {

inline bool within(const Limits& limits, double value) {
  return value > limits.above && value >= limits.at_least && value <= limits.at_most;
}

// "above 0 and at most 1 m", or nothing.
inline std::string range_in_words(const Limits& limits) {
  std::string words;
  const auto say = [&](const char* relation, double bound) {
    words += fmt::format("{}{} {}", words.empty() ? "" : " and ", relation, shown(bound));
  };
  if (limits.above != -unbounded) say("above", limits.above);
  if (limits.at_least != -unbounded) say("at least", limits.at_least);
  if (limits.at_most != unbounded) say("at most", limits.at_most);
  if (!words.empty() && limits.unit != "-") words += fmt::format(" {}", limits.unit);
  return words;
}

}  // namespace trackbed::input
