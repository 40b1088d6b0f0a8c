// Sums whose result does not depend on the order of the terms.
//
// Floating-point addition is not associative, so a force on a surface node, gathered from stones on
// several ranks, would change its last bits with the number of ranks. Here each term is rounded
// once to a multiple of a fixed quantum and added as an integer, which is associative: the sum is
// bitwise identical for any order and any split over ranks. The price is an absolute resolution of
// one quantum and a range of 2^63 quanta (par::Comm sums the integers across ranks).
#pragma once

#include <cmath>
#include <cstdint>

#include "trackbed/core/types.hpp"

namespace trackbed {

// Power of two such that sums up to `largest` (same unit as the terms) stay below overflow by a
// factor of 8; the resolution is then largest * 2^-60.
inline double exact_quantum(double largest) {
  return std::ldexp(1.0, static_cast<int>(std::ceil(std::log2(largest))) - 60);
}

class ExactSum {
 public:
  // `quantum` must be a power of two, equal on all ranks.
  explicit ExactSum(double quantum = exact_quantum(1e12))
      : quantum_(quantum), inverse_(1.0 / quantum) {}
  void add(double term) { count_ += std::llrint(term * inverse_); }
  double value() const { return static_cast<double>(count_) * quantum_; }
  std::int64_t& count() { return count_; }
  std::int64_t count() const { return count_; }

 private:
  double quantum_, inverse_;
  std::int64_t count_ = 0;
};

}  // namespace trackbed
