// Of the mirrored profile the cosine transform is the whole spectrum, so the root mean square
// follows from its lines (Parseval) and nothing is transformed back:
//   v_i = a_0/n + 2/n sum_j a_j cos(pi j (i + 1/2)/n),   mean square of line j: 2 a_j^2/n^2,
//   |H|^2 = 1/(1 + W^(2 N)),  W = (k^2 - k_1 k_2)/(k (k_2 - k_1)),  k = j/(2 n step) in 1/m, N = 4.
// Only lines in and near the band are needed, so the plain sums cost less than they look: a second
// for 2 km in steps of 0.1 m. The same filter as postproc/track_measures.py has.
#include "band.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace trackbed::track {

namespace {

constexpr int order = 4;
constexpr double reach = 4;  // of the upper border: beyond it less than 1e-5 of the power passes

// The least squares line, about the middle of the profile.
void take_line_out(std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0, moment = 0;
  const auto from_middle = [n](std::size_t i) { return static_cast<double>(i) - (n - 1) / 2; };
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += values[i], moment += values[i] * from_middle(i);
  const double slope = moment * 12 / (n * (n * n - 1));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= sum / n + slope * from_middle(i);
}

double cosine_sum(const std::vector<double>& values, double angle) {
  const std::complex<double> turn = std::polar(1.0, angle);
  std::complex<double> at = std::polar(1.0, angle / 2);
  double sum = 0;
  for (const double value : values) {
    sum += value * at.real();
    at *= turn;
  }
  return sum;
}

}  // namespace

double band_rms(std::vector<double> values, double step, double shortest, double longest) {
  if (values.size() < 2) return 0;
  take_line_out(values);
  const auto n = static_cast<double>(values.size());
  const double low = 1 / longest, high = 1 / shortest;
  double square = 0;
  for (double j = 1; j < n && j / (2 * n * step) < reach * high; ++j) {
    const double k = j / (2 * n * step);
    const double w = (k * k - low * high) / (k * (high - low));
    const double line = cosine_sum(values, std::numbers::pi * j / n) / n;
    square += 2 * line * line / (1 + std::pow(w, 2 * order));
  }
  return std::sqrt(square);
}

}  // namespace trackbed::track
