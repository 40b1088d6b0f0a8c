// Whole numbers of time steps. Decks give times and steps as decimal numbers, whose quotient errs
// by rounding: 0.3 / 0.1 must be 3 steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace trackbed {

// Relative; far above the rounding of a quotient and far below what a deck means by its digits.
inline constexpr double rounding_of_steps = 1e-9;

// Steps of at most `longest` (s) that cover `time` (s): rounded up, at least one. The first is not
// limited to what an integer can hold.
inline double number_covering(double time, double longest) {
  return std::max(1.0, std::ceil(time / longest * (1 - rounding_of_steps)));
}
inline std::int64_t steps_covering(double time, double longest) {
  return std::llround(number_covering(time, longest));
}

// Steps of `step` (s) in `interval` (s): the nearest whole number, at least one.
inline std::int64_t steps_within(double interval, double step) {
  return std::max<std::int64_t>(1, std::llround(interval / step));
}

}  // namespace trackbed
