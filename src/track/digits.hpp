// Whether a matrix of stiffnesses keeps digits when it is factorised. Private to the room.
#pragma once

#include <fmt/format.h>

#include <Eigen/Dense>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

// Digits are lost where little of a stiffness is left beside a part it hangs on that is far
// stiffer: with a fraction of 1e-10 left, results keep six of sixteen.
inline constexpr double least_left = 1e-10;

// `pivots` of the factors, and the entries of the diagonal they were left of: N/m, or N m of
// rotations. Throws InputError.
inline void require_digits(const Eigen::VectorXd& pivots, const Eigen::VectorXd& diagonal) {
  for (Eigen::Index k = 0; k < diagonal.size(); ++k)
    if (!(pivots[k] > least_left * diagonal[k]))
      throw InputError({fmt::format(
          "the track's stiffnesses are too far apart to be computed with in 16 digits: of "
          "{:.3g} N/m (rotations: N m) of an unknown {:.2g} of it are left beside the stiffer "
          "parts "
          "that it is joined to, and {:g} must be; lower the largest stiffness of rail, pads, "
          "ballast or springs, or raise the lowest",
          diagonal[k], pivots[k] / diagonal[k], least_left)});
}

}  // namespace trackbed::track
