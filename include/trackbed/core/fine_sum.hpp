// Exact sums of terms that are much smaller than the largest possible sum (exact_sum.hpp).
//
// The remainder of a term after rounding to the first quantum is exact in double precision; it is
// added to a second sum with a quantum of 2^-32 of the first. Terms are therefore rounded to
// largest * 2^-92, and the sum is bitwise identical for any order and any split over ranks.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "trackbed/core/exact_sum.hpp"

namespace trackbed {

class FineSum {
 public:
  // `largest` as for exact_quantum, equal on all ranks.
  explicit FineSum(double largest)
      : quantum_(exact_quantum(largest)), fine_(std::ldexp(quantum_, -32)) {}
  void add(double term) {
    const std::int64_t whole = std::llrint(term / quantum_);
    counts_[0] += whole;
    counts_[1] += std::llrint((term - static_cast<double>(whole) * quantum_) / fine_);
    carry();
  }
  double value() const {
    return static_cast<double>(counts_[0]) * quantum_ + static_cast<double>(counts_[1]) * fine_;
  }
  // After these are added up over ranks, call carry().
  std::array<std::int64_t, 2>& counts() { return counts_; }
  const std::array<std::int64_t, 2>& counts() const { return counts_; }
  // Moves whole quanta to the first count, so that equal sums have equal counts.
  void carry() {
    const std::int64_t whole = counts_[1] >> 32;
    counts_[0] += whole;
    counts_[1] -= whole << 32;
  }

 private:
  double quantum_, fine_;
  std::array<std::int64_t, 2> counts_{};
};

}  // namespace trackbed
