// The cosine transform is the complete spectrum of the mirrored profile, so that the root mean
// square follows from its lines (Parseval) without an inverse transform:
//   v_i = a_0/n + 2/n sum_j a_j cos(pi j (i + 1/2)/n),   mean square of line j: 2 a_j^2/n^2,
//   |H|^2 = 1/(1 + W^(2 N)),  W = (k^2 - k_1 k_2)/(k (k_2 - k_1)),  k = j/(2 n step) in 1/m, N = 4.
// The lines in and near the band come from one convolution: with c_k = exp(sqrt(-1) pi k^2/(2n)),
//   sum_i v_i exp(sqrt(-1) pi i j/n) = c_j sum_i (v_i c_i) conj(c_(j-i)),
// by fast transforms of a length that is a power of two (Bluestein 1970,
// doi:10.1109/TAU.1970.1162132): cost n log n, also for prime n. track_measures.py has the
// same filter.
#include "track/line/band.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace trackbed::track {

namespace {

constexpr int order = 4;
// Times the upper limit: at larger wave numbers less than 1e-5 of the power passes.
constexpr double reach = 4;

// Subtracts the least squares line, about the middle of the profile.
void subtract_line(std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0, moment = 0;
  const auto from_middle = [n](std::size_t i) { return static_cast<double>(i) - (n - 1) / 2; };
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += values[i], moment += values[i] * from_middle(i);
  const double slope = moment * 12 / (n * (n * n - 1));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= sum / n + slope * from_middle(i);
}

using Complex = std::complex<double>;

// exp(i pi k^2/(2n)), with an angle that is accurate at any k.
Complex chirp(std::uint64_t k, std::uint64_t n) {
  const std::uint64_t turns = k * k % (4 * n);
  return std::polar(1.0,
                    std::numbers::pi * static_cast<double>(turns) / (2 * static_cast<double>(n)));
}

// a_j above for j below `lines`.
std::vector<double> cosine_sums(const std::vector<double>& values, std::size_t lines) {
  const std::size_t n = values.size(), length = std::bit_ceil(n + lines);
  std::vector<Complex> turned(length), turns(length), product(length);
  for (std::size_t i = 0; i < n; ++i) turned[i] = values[i] * chirp(i, n);
  for (std::size_t j = 0; j < lines; ++j) turns[j] = std::conj(chirp(j, n));
  for (std::size_t i = 1; i < n; ++i) turns[length - i] = std::conj(chirp(i, n));
  Eigen::FFT<double> transform;
  std::vector<Complex> one, other;
  transform.fwd(one, turned), transform.fwd(other, turns);
  for (std::size_t k = 0; k < length; ++k) product[k] = one[k] * other[k];
  transform.inv(turned, product);
  std::vector<double> sums(lines);
  for (std::size_t j = 0; j < lines; ++j) {
    const double half = std::numbers::pi * static_cast<double>(j) / (2 * static_cast<double>(n));
    sums[j] = (std::polar(1.0, half) * chirp(j, n) * turned[j]).real();
  }
  return sums;
}

}  // namespace

double band_rms(std::vector<double> values, double step, double shortest, double longest) {
  if (values.size() < 2) return 0;
  subtract_line(values);
  const auto n = static_cast<double>(values.size());
  const double low = 1 / longest, high = 1 / shortest;
  const double within = std::min(n, std::ceil(reach * high * 2 * n * step));
  const std::vector<double> sums = cosine_sums(values, static_cast<std::size_t>(within));
  double square = 0;
  for (std::size_t j = 1; j < sums.size(); ++j) {
    const double k = static_cast<double>(j) / (2 * n * step);
    const double w = (k * k - low * high) / (k * (high - low));
    const double line = sums[j] / n;
    square += 2 * line * line / (1 + std::pow(w, 2 * order));
  }
  return std::sqrt(square);
}

}  // namespace trackbed::track
