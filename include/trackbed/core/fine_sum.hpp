// Exact sums of terms much smaller than what the sum may grow to (exact_sum.hpp).
//
// What rounding to the first quantum leaves of a term is exact in double precision; it goes to a
// second sum, of 2^-32 of the first quantum. So terms are rounded to that, largest * 2^-92, and any
// order and any split over ranks still gives the same bits.
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
  // Add up over ranks, and carry then.
  std::array<std::int64_t, 2>& counts() { return counts_; }
  const std::array<std::int64_t, 2>& counts() const { return counts_; }
  // Whole quanta to the first count: the same two counts for the same sum.
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
