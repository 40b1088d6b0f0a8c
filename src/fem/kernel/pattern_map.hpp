// A matrix between values at the corners or Gauss points of a box, stored as a short list between
// their patterns. Mirror symmetry leaves at most an eighth of the entries in space, a quarter in a
// plane.
//
// The non-zero entries are found from their values and not derived from the kind of quantity:
// stress from displacement, stress from strain and force from strain use the same code. Rejected:
// blocks as in stiffness.hpp (faster without indices, but one layout for each pair of quantities).
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "fem/shape/lanes.hpp"

namespace trackbed::fem {

class PatternMap {
 public:
  PatternMap() = default;
  // Rows and columns of `matrix` are ordered rows * corner + component.
  PatternMap(const Eigen::MatrixXd& matrix, int rows, int columns, int corners) {
    // With u_k = 1/n sum_p s_pk m_p and f_k = sum_p s_pk t_p: t = 1/n^2 P M P^T m.
    const Eigen::MatrixXd t = patterns_of(corners, rows) * matrix *
                              patterns_of(corners, columns).transpose() / (corners * corners);
    const double noise = 1e-13 * t.cwiseAbs().maxCoeff();  // rounding error of zero entries
    begin_.push_back(0);
    for (int c = 0; c < rows; ++c)
      for (int p = 0; p < corners; ++p) {
        for (int d = 0; d < columns; ++d)
          for (int q = 0; q < corners; ++q) {
            const double value = t(p * rows + c, q * columns + d);
            if (std::abs(value) <= noise) continue;
            column_.push_back(d * corners + q);
            value_.push_back(value);
          }
        begin_.push_back(static_cast<std::int32_t>(value_.size()));
      }
  }

  std::size_t entries() const { return value_.size(); }
  // From patterns to patterns, component by component: index component * corners + pattern. The
  // result needs only to_corners: the factors are in the list.
  void apply(const Lane* from, Lane* to) const {
    for (std::size_t row = 0; row + 1 < begin_.size(); ++row) {
      Lane sum = {};
      for (std::int32_t k = begin_[row]; k < begin_[row + 1]; ++k)
        sum += value_[static_cast<std::size_t>(k)] * from[column_[static_cast<std::size_t>(k)]];
      to[row] = sum;
    }
  }
  std::size_t bytes() const { return value_.capacity() * 12 + begin_.capacity() * 4; }

 private:
  std::vector<std::int32_t> begin_, column_;  // row by row
  std::vector<double> value_;
};

}  // namespace trackbed::fem
