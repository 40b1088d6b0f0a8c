// Limits in words, with the same wording in messages and in the reference. Private to the module.
#pragma once

#include <fmt/format.h>

#include <string>

#include "input/tree.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::input {

// False for NaN, whose comparisons are all false.
inline bool within(const Limits& limits, double value) {
  return value > limits.above && value >= limits.at_least && value <= limits.at_most;
}

// Zero is always accepted: it mostly means "none" or "automatic". Both ends of the usual range are
// included.
inline bool usual(const Limits& limits, double value) {
  return value == 0 || (value >= limits.usually_from && value <= limits.usually_to);
}

// "1e+05 to 1e+12", "at most 5", or nothing.
inline std::string usual_in_words(const Limits& limits) {
  const bool from = limits.usually_from != -unbounded, to = limits.usually_to != unbounded;
  if (from && to) return fmt::format("{:g} to {:g}", limits.usually_from, limits.usually_to);
  if (from) return fmt::format("at least {:g}", limits.usually_from);
  return to ? fmt::format("at most {:g}", limits.usually_to) : "";
}

// "above 0 and at most 1 m", or nothing. `unit` "-": a number without unit.
// All bounds in one sentence, joined by "and", with the unit once at the end.
inline std::string range_in_words(const Limits& limits) {
  std::string words;
  const auto add = [&](const char* relation, double bound) {
    words += fmt::format("{}{} {}", words.empty() ? "" : " and ", relation, shown(bound));
  };
  if (limits.above != -unbounded) add("above", limits.above);
  if (limits.at_least != -unbounded) add("at least", limits.at_least);
  if (limits.at_most != unbounded) add("at most", limits.at_most);
  if (!words.empty() && limits.unit != "-") words += fmt::format(" {}", limits.unit);
  return words;
}

}  // namespace trackbed::input
