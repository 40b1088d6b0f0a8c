// Band pass of a profile: fast transforms against direct sums of its spectral lines.
#include "track/line/band.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace trackbed::track::band_test {
namespace {

// For values without mean and slope.
double direct(const std::vector<double>& values, double step, double shortest, double longest) {
  const auto n = static_cast<double>(values.size());
  const double low = 1 / longest, high = 1 / shortest;
  double square = 0;
  for (double j = 1; j < n; ++j) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += values[i] * std::cos(std::numbers::pi * j * (static_cast<double>(i) + 0.5) / n);
    const double k = j / (2 * n * step), w = (k * k - low * high) / (k * (high - low));
    square += 2 * sum * sum / (n * n) / (1 + std::pow(w, 8));
  }
  return std::sqrt(square);
}

// Waves in, above and below the band, symmetric about the middle; lengths that are prime and powers
// of two. Beyond four times the limit, which is omitted, 1e-5 of the power passes.
TEST(Band, EqualsDirectSums) {
  for (const std::size_t n : {17U, 256U, 1009U, 1200U}) {
    std::vector<double> values;
    double mean = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = std::abs(0.1 * (static_cast<double>(i) - (static_cast<double>(n) - 1) / 2));
      values.push_back(1e-3 * (std::cos(1.1 * x) + 0.5 * std::cos(4 * x) + 2 * std::cos(0.1 * x)));
      mean += values.back() / static_cast<double>(n);
    }
    for (double& value : values) value -= mean;
    const double wanted = direct(values, 0.1, 3, 25);
    EXPECT_NEAR(band_rms(values, 0.1, 3, 25), wanted, 1e-4 * wanted) << n;
  }
}

TEST(Band, IsFastForALongProfile) {
  std::vector<double> values;
  for (int i = 0; i < 2'000'003; ++i) values.push_back(1e-3 * std::sin(0.1 * i));
  EXPECT_NEAR(band_rms(values, 0.1, 3, 25), 1e-3 * std::sqrt(0.5), 1e-5);
}

}  // namespace
}  // namespace trackbed::track::band_test
