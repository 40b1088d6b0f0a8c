// Samples of a wave and their Fourier transform.
//
// Rows of a table may be of any distance, so the wave is sampled anew: means over short steps, from
// its displacement, in which nothing between two rows is lost. Cost: one fast transform (Cooley,
// Tukey 1965, doi:10.1090/S0025-5718-1965-0178586-1) of 2^16 numbers, some milliseconds.
#include "wave_band.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

namespace trackbed::fem {

namespace {

using Numbers = std::vector<std::complex<double>>;

constexpr std::size_t samples = std::size_t{1} << 14;
// Zeros behind the wave make frequencies of a short one denser.
constexpr std::size_t padded = 4 * samples;

// Half of the numbers at a time, in place; their count is a power of two.
void transform(Numbers& values) {
  const std::size_t count = values.size();
  for (std::size_t i = 1, j = 0; i < count; ++i) {  // into the order of reversed bits
    std::size_t bit = count / 2;
    for (; (j & bit) != 0; bit /= 2) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (std::size_t length = 2; length <= count; length *= 2) {
    const std::complex<double> turn =
        std::polar(1.0, -2 * std::numbers::pi / static_cast<double>(length));
    for (std::size_t first = 0; first < count; first += length) {
      std::complex<double> factor = 1;
      for (std::size_t k = first; k < first + length / 2; ++k, factor *= turn) {
        const std::complex<double> even = values[k], odd = factor * values[k + length / 2];
        values[k] = even + odd;
        values[k + length / 2] = even - odd;
      }
    }
  }
}

}  // namespace

WaveBand::WaveBand(const BaseMotion& wave, int axis)
    : begin_(std::max(wave.begin(), 0.0)),
      step_(std::max(wave.end() - begin_, 0.0) / static_cast<double>(samples)) {
  if (step_ <= 0) return;
  double before = wave.at(begin_).displacement[axis];
  for (std::size_t k = 1; k <= samples; ++k) {
    const double now = wave.at(begin_ + static_cast<double>(k) * step_).displacement[axis];
    velocity_.push_back((now - before) / step_);
    before = now;
  }
}

double WaveBand::energy() const {
  return step_ * std::inner_product(velocity_.begin(), velocity_.end(), velocity_.begin(), 0.0);
}

double WaveBand::energy_until(double time) const {
  double sum = 0;
  for (std::size_t k = 0; k < velocity_.size(); ++k)
    if (begin_ + static_cast<double>(k + 1) * step_ <= time) sum += velocity_[k] * velocity_[k];
  return step_ * sum;
}

double WaveBand::time_of(double share) const {
  const double wanted = share * energy() / step_;
  double sum = 0;
  std::size_t k = 0;
  for (; k < velocity_.size() && sum < wanted; ++k) sum += velocity_[k] * velocity_[k];
  return begin_ + static_cast<double>(k) * step_;
}

double WaveBand::frequency_of(double share) const {
  if (energy() <= 0) return 0;
  Numbers values(padded);
  std::copy(velocity_.begin(), velocity_.end(), values.begin());
  transform(values);
  // A real wave's spectrum is its own mirror image: one half of it tells all. Each number stands
  // for the frequencies half a step below it to half a step above.
  double all = 0, sum = 0, last = 0;
  for (std::size_t k = 0; k < padded / 2; ++k) all += std::norm(values[k]);
  std::size_t k = 0;
  for (; k < padded / 2 && sum < share * all; ++k) sum += last = std::norm(values[k]);
  const double steps = static_cast<double>(k) - 0.5 - (last > 0 ? (sum - share * all) / last : 0);
  return std::max(steps, 0.0) / (static_cast<double>(padded) * step_);
}

}  // namespace trackbed::fem
