// Sums over terms on all ranks that are bitwise identical for any split: the range follows from the
// largest term and the number of terms, both exact, the sum from integers (core/exact_sum.hpp).
//
// Each term is read twice, since the range must be known before the first one is added: callers
// keep them. Many sums are computed at once, because every reduction waits for the slowest rank.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/core/exact_sum.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::par {

// Number of sums; sum k has the range k % ranges, so that sums of one unit share one.
struct ExactLayout {
  std::size_t sums = 1, ranges = 1;
};

struct ExactTerm {
  std::size_t sum;
  double value;
};

// `term(k)` is this rank's ExactTerm k of `count`. If a term of a range is not finite, all sums of
// this range equal the largest of its terms. Collective, three reductions.
template <class TermAt>
std::vector<double> exact_totals(const Comm& comm, const ExactLayout& layout, std::size_t count,
                                 TermAt&& term) {
  std::vector<double> largest(layout.ranges, 0.0);
  std::vector<std::int64_t> terms(layout.ranges, 0);
  for (std::size_t k = 0; k < count; ++k) {
    const auto [sum, value] = term(k);
    double& range = largest[sum % layout.ranges];
    range = std::max(range, std::abs(value));
    ++terms[sum % layout.ranges];
  }
  comm.max(std::span(largest));
  comm.sum(std::span(terms));
  const auto summed = [&](std::size_t sum) {
    return largest[sum % layout.ranges] > 0 && std::isfinite(largest[sum % layout.ranges]);
  };
  std::vector<ExactSum> sums;
  for (std::size_t k = 0; k < layout.sums; ++k)
    sums.emplace_back(summed(k) ? exact_quantum(largest[k % layout.ranges] *
                                                static_cast<double>(terms[k % layout.ranges]))
                                : 1.0);
  for (std::size_t k = 0; k < count; ++k)
    if (const auto [sum, value] = term(k); summed(sum)) sums[sum].add(value);
  std::vector<std::int64_t> counts;
  for (const ExactSum& sum : sums) counts.push_back(sum.count());
  comm.sum(std::span(counts));
  std::vector<double> values;
  for (std::size_t k = 0; k < layout.sums; ++k) {
    sums[k].count() = counts[k];
    values.push_back(summed(k) ? sums[k].value() : largest[k % layout.ranges]);
  }
  return values;
}

}  // namespace trackbed::par
