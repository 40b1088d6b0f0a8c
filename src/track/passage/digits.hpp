// Check of the accuracy of a factorised stiffness matrix. Private to the module.
#pragma once

#include <fmt/format.h>

#include <Eigen/Dense>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

// Digits are lost by elimination where a soft part is connected to a much stiffer one: with a ratio
// of pivot to diagonal of 1e-10, results keep six of sixteen digits.
inline constexpr double least_pivot = 1e-10;

// `pivots` of the factors and the diagonal of the matrix: N/m, or N m for rotations. Throws
// InputError.
inline void require_digits(const Eigen::VectorXd& pivots, const Eigen::VectorXd& diagonal) {
  for (Eigen::Index k = 0; k < diagonal.size(); ++k)
    if (!(pivots[k] > least_pivot * diagonal[k]))
      throw InputError(
          {fmt::format("the stiffnesses of the track differ too much for the solver: the ratio of "
                       "pivot to diagonal is {:.2g} (required: above {:g}) at a diagonal term of "
                       "{:.3g} N/m (rotation: N m); reduce the largest stiffness of rail, pads, "
                       "ballast or springs, or increase the smallest",
                       pivots[k] / diagonal[k], least_pivot, diagonal[k])});
}

}  // namespace trackbed::track
