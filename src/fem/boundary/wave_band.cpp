// Samples of a wave and their Fourier transform.
//
// Rows of a table may have any spacing, so the wave is resampled: means over short steps. Cost: one
// fast transform of 2^16 numbers, some milliseconds.
#include "fem/boundary/wave_band.hpp"

#include <algorithm>
#include <complex>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace trackbed::fem {

namespace {

constexpr std::size_t samples = std::size_t{1} << 14;
// Zero padding refines the frequencies of a short wave.
constexpr std::size_t padded = 4 * samples;

}  // namespace

WaveBand::WaveBand(const BaseMotion& wave, int axis)
    : begin_(std::max(wave.begin(), 0.0)),
      step_(std::max(wave.end() - begin_, 0.0) / static_cast<double>(samples)) {
  if (step_ <= 0) return;
  constexpr int parts = 8;  // of a step, each at its middle, so that rows between samples count
  for (std::size_t k = 0; k < samples; ++k) {
    double sum = 0;
    for (int part = 0; part < parts; ++part)
      sum += wave.at(begin_ + (static_cast<double>(k) + (part + 0.5) / parts) * step_)[axis];
    velocity_.push_back(sum / parts);
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

double WaveBand::time_of(double fraction) const {
  const double wanted = fraction * energy() / step_;
  double sum = 0;
  std::size_t k = 0;
  for (; k < velocity_.size() && sum < wanted; ++k) sum += velocity_[k] * velocity_[k];
  return begin_ + static_cast<double>(k) * step_;
}

double WaveBand::frequency_of(double fraction) const {
  if (energy() <= 0) return 0;
  std::vector<double> padded_velocity = velocity_;
  padded_velocity.resize(padded);
  std::vector<std::complex<double>> values;
  Eigen::FFT<double>().fwd(values, padded_velocity);
  // The spectrum of a real wave is symmetric: one half of it suffices. Each value represents the
  // frequencies from half a step below to half a step above.
  double all = 0, sum = 0, last = 0;
  for (std::size_t k = 0; k < padded / 2; ++k) all += std::norm(values[k]);
  std::size_t k = 0;
  for (; k < padded / 2 && sum < fraction * all; ++k) sum += last = std::norm(values[k]);
  const double steps =
      static_cast<double>(k) - 0.5 - (last > 0 ? (sum - fraction * all) / last : 0);
  return std::max(steps, 0.0) / (static_cast<double>(padded) * step_);
}

}  // namespace trackbed::fem
