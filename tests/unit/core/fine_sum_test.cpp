// Fine sums: small terms with a large range, in any order and in parts.
#include "trackbed/core/fine_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace trackbed::fine_sum_test {
namespace {

constexpr double range = 1e8;
constexpr double resolution = 0x1p-65;  // range 2^-92, to a power of two

double plain(const std::vector<double>& terms) {
  double sum = 0;
  for (const double term : terms) sum += term;
  return sum;
}

FineSum fine(const std::vector<double>& terms) {
  FineSum sum(range);
  for (const double term : terms) sum.add(term);
  return sum;
}

// Each small term is half of the spacing of doubles at the large one.
TEST(FineSum, KeepsWhatDoublesLose) {
  constexpr double large = 0x1p26, small = 0x1p-27;
  constexpr int count = 100000;
  std::vector<double> terms(count + 2, small);
  terms.front() = large, terms.back() = -large;
  EXPECT_EQ(plain(terms), 0);
  EXPECT_EQ(fine(terms).value(), count * small);
  ExactSum exact(exact_quantum(range));
  for (std::size_t n = 0; n < 1000; ++n) exact.add(0x1p-34);  // half of its quantum
  EXPECT_NE(exact.value(), 1000 * 0x1p-34);
  EXPECT_EQ(fine(std::vector<double>(1000, 0x1p-34)).value(), 1000 * 0x1p-34);
}

// Multiples of the resolution, of both signs and all sizes, are summed without error; other terms
// to half of it each.
__extension__ using Wide = __int128;

TEST(FineSum, RoundsEachTermToTheResolution) {
  std::mt19937_64 random(3);
  std::vector<double> terms;
  Wide whole = 0;  // of the resolution
  for (int n = 0; n < 10000; ++n) {
    const auto number = static_cast<std::int64_t>(random()) >> (11 + random() % 50);
    terms.push_back(static_cast<double>(number) * resolution);
    whole += number;
  }
  const FineSum sum = fine(terms);
  const Wide found = (static_cast<Wide>(sum.counts()[0]) << 32) + sum.counts()[1];
  EXPECT_TRUE(found == whole);
  for (double& term : terms) term *= 1 + 0x1p-40;
  long double exact = 0;
  for (const double term : terms) exact += term;
  EXPECT_LE(std::abs(static_cast<double>(fine(terms).value() - exact)), 10000 * resolution / 2);
}

// The same two counts for any order and any partition of the terms.
TEST(FineSum, DoesNotDependOnOrder) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  std::vector<double> terms(5000);
  // Twelve decades, whose sums stay within the range.
  for (double& term : terms) term = normal(random) * std::exp(4 * normal(random));
  const FineSum forwards = fine(terms);
  std::shuffle(terms.begin(), terms.end(), random);
  EXPECT_EQ(fine(terms).counts(), forwards.counts());
  FineSum whole(range);
  for (std::size_t from = 0; from < terms.size(); from += 1000) {
    const FineSum part = fine({terms.begin() + static_cast<std::ptrdiff_t>(from),
                               terms.begin() + static_cast<std::ptrdiff_t>(from + 1000)});
    for (std::size_t k = 0; k < 2; ++k) whole.counts()[k] += part.counts()[k];
  }
  whole.carry();
  EXPECT_EQ(whole.counts(), forwards.counts());
}

// More small terms than the second count could hold without carrying: each is just below half of a
// quantum, and 2^32 of the resolution.
TEST(FineSum, CarriesAndStaysInRange) {
  FineSum sum(range);
  constexpr double term = 0x1p-34 - resolution;
  constexpr int count = 1000000;
  for (int n = 0; n < count; ++n) sum.add(term);
  EXPECT_GE(sum.counts()[1], 0);
  EXPECT_LT(sum.counts()[1], std::int64_t{1} << 32);
  EXPECT_EQ(sum.value(), count * 0x1p-34 - count * resolution);
}

}  // namespace
}  // namespace trackbed::fine_sum_test
