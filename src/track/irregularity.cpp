// Dips in closed form; spectra and measured profiles as samples with a cubic between them, so that
// a wheel reads them in constant time and feels no kinks.
//
// A spectrum is a sum of cosines with random phases on wave numbers spaced evenly in their
// logarithm: the amplitude of each is exact for the power in its band, so the root mean square does
// not depend on the draw (Shinozuka and Deodatis 1991, doi:10.1115/1.3119501). The same seed gives
// the same profile on any machine and number of ranks.
// Rejected: filtered noise and inverse Fourier transform, which tie the profile to its length.
#include "trackbed/track/irregularity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::track {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
constexpr int lines = 400;
constexpr double d1_shortest = 3, d1_longest = 25;  // m, EN 13848-1

// ERRI B176, A in m rad: A Wc^2/((W^2 + Wr^2)(W^2 + Wc^2)).
double erri(double amount, double w) {
  constexpr double wc = 0.8246, wr = 0.0206;  // rad/m
  return amount * wc * wc / ((w * w + wr * wr) * (w * w + wc * wc));
}

// FRA, A in cm^2 rad/m: k A Wc^2/(W^2 (W^2 + Wc^2)).
double fra(std::size_t track_class, double w) {
  constexpr std::array amount = {1.2107, 1.0181, 0.6816, 0.5376, 0.2095, 0.0339};
  constexpr double wc = 0.8245, k = 0.25, square_metre = 1e-4;
  return k * amount[track_class - 1] * square_metre * wc * wc / (w * w * (w * w + wc * wc));
}

// TB/T 3352 ballastless: A/f^n in mm^2/(1/m), f in 1/m. S_W(W) = S_f(W/2 pi)/(2 pi).
double china(double w) {
  constexpr std::array end = {0.0187, 0.0474, 0.1533};
  constexpr std::array amount = {1.0544e-5, 3.5588e-3, 1.9784e-2, 3.9488e-4};
  constexpr std::array power = {3.3891, 1.9271, 1.3643, 3.4516};
  const double f = w / two_pi;
  const auto band =
      static_cast<std::size_t>(std::upper_bound(end.begin(), end.end(), f) - end.begin());
  constexpr double square_metre = 1e-6;
  return amount[band] * std::pow(f, -power[band]) * square_metre / two_pi;
}

// From 0 to 1 with level ends.
double smooth_step(double s) {
  const double t = std::clamp(s, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

// One-sided: the mean square of a band is the integral over positive wave numbers.
double density_of(Spectrum spectrum, double wave_number) {
  switch (spectrum) {
    case Spectrum::erri_low:
      return erri(4.032e-7, wave_number);
    case Spectrum::erri_high:
      return erri(1.08e-6, wave_number);
    case Spectrum::china:
      return china(wave_number);
    default:
      break;
  }
  const auto first = static_cast<std::size_t>(Spectrum::fra_1);
  return fra(static_cast<std::size_t>(spectrum) - first + 1, wave_number);
}

// Midpoint rule in ln W: 1e4 steps give six digits, also across the kinks of the Chinese spectrum.
double rms_of(Spectrum spectrum, double shortest, double longest) {
  constexpr int steps = 10000;
  const double low = two_pi / longest, step = std::log(longest / shortest) / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double w = low * std::exp((i + 0.5) * step);
    sum += density_of(spectrum, w) * w * step;
  }
  return std::sqrt(sum);
}

// Each kind uses some of these; brackets and the kind's words say which.
void IrregularityParameters::declare(input::Section& s) {
  s.choice("kind", kind, {"none", "versine", "vee", "joint", "waves", "spectrum", "file", "same"},
           "Shape of the running surface: even; a dip that is smooth, of two ramps, or of two "
           "parabolas that meet in a point; smooth dips one after the other; random from a "
           "spectrum; measured; same: of a right rail, as the left one.");
  s.number("at", at, {.unit = "m"}, "x of the middle of the dip, or of the begin of the waves.");
  s.number("depth", depth, {.unit = "m", .usually_from = -0.02, .usually_to = 0.02},
           "Depth of dip or waves; negative: a bump.");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 200},
           "Length of the dip, or of one wave.");
  s.integer("waves", waves, {.at_least = 1}, "Number of waves.");
  s.choice("spectrum", spectrum,
           {"erri_low", "erri_high", "fra_1", "fra_2", "fra_3", "fra_4", "fra_5", "fra_6", "china"},
           "Vertical profile after ERRI B176, FRA track classes, or TB/T 3352 (ballastless).");
  s.number("shortest", shortest, {.unit = "m", .above = 0, .usually_to = 10},
           "Shortest wavelength of the spectrum.");
  s.number("longest", longest, {.unit = "m", .above = 0, .usually_to = 300},
           "Longest wavelength of the spectrum.");
  s.integer("seed", seed, {.at_least = 0}, "Number that chooses the random profile.");
  s.number("fade", fade, {.unit = "m", .at_least = 0},
           "Way from the begin of the track over which spectrum or file fade in.");
  s.file("file", file, "CSV with columns x_m, z_m (upwards), x rising; straight where it is not.");
  s.rule("file", kind != IrregularityKind::file || !file.empty(), "is needed for kind = \"file\"");
  s.rule("longest", longest > shortest, "must be longer than the shortest");
}

// Closed forms need no samples.
Irregularity::Irregularity(const IrregularityParameters& parameters, double length)
    : parameters_(parameters) {
  if (parameters.kind == IrregularityKind::spectrum) draw(length);
  if (parameters.kind == IrregularityKind::file) read(length);
}

// Slopes come with the samples: the cubic is then off by (W spacing)^4/384 of a line, below 3e-5.
void Irregularity::draw(double length) {
  const IrregularityParameters& p = parameters_;
  constexpr double samples_per_wave = 20;
  spacing_ = p.shortest / samples_per_wave;
  const auto count = static_cast<std::size_t>(std::ceil(length / spacing_)) + 2;
  height_.assign(count, 0);
  slope_.assign(count, 0);
  const double ratio = std::log(p.longest / p.shortest) / lines;
  double d1 = 0;
  for (int i = 0; i < lines; ++i) {
    const double w = two_pi / p.longest * std::exp((i + 0.5) * ratio);
    const double power = density_of(p.spectrum, w) * w * ratio;  // m^2
    const double wavelength = two_pi / w;
    if (wavelength >= d1_shortest && wavelength <= d1_longest) d1 += power;
    const double phase =
        two_pi * uniform(static_cast<std::uint64_t>(p.seed), static_cast<std::uint64_t>(i));
    const double amplitude = std::sqrt(2 * power);
    for (std::size_t k = 0; k < count; ++k) {
      const double angle = w * static_cast<double>(k) * spacing_ + phase;
      height_[k] += amplitude * std::cos(angle);
      slope_[k] -= amplitude * w * std::sin(angle);
    }
  }
  d1_ = std::sqrt(d1);
}

// Resampled evenly by straight lines between the rows; slopes are central differences.
void Irregularity::read(double length) {
  const auto columns = input::read_table(parameters_.file, {"x_m", "z_m"}, "x_m");
  const std::vector<double>&x = columns[0], &z = columns[1];
  if (x.size() < 2) throw InputError({parameters_.file + ": needs at least two rows"});
  spacing_ = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
  const auto count = static_cast<std::size_t>(std::ceil(length / spacing_)) + 2;
  for (std::size_t k = 0; k < count; ++k) {
    const double at = static_cast<double>(k) * spacing_;
    const auto next = std::upper_bound(x.begin(), x.end(), at);
    if (next == x.begin() || next == x.end()) {
      height_.push_back(next == x.begin() ? z.front() : z.back());
      continue;
    }
    const auto i = static_cast<std::size_t>(next - x.begin());
    height_.push_back(z[i - 1] + (z[i] - z[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]));
  }
  slope_.assign(count, 0);
  for (std::size_t k = 1; k + 1 < count; ++k)
    slope_[k] = (height_[k + 1] - height_[k - 1]) / (2 * spacing_);
}

// Cubic Hermite between samples.
double Irregularity::sampled(double x) const {
  if (x <= 0) return 0;
  const double along = std::min(x / spacing_, static_cast<double>(height_.size() - 1) - 1e-9);
  const auto k = static_cast<std::size_t>(along);
  const double t = along - static_cast<double>(k), left = 1 - t;
  const double value = left * left * (1 + 2 * t) * height_[k] +
                       t * t * (3 - 2 * t) * height_[k + 1] +
                       t * left * spacing_ * (left * slope_[k] - t * slope_[k + 1]);
  return parameters_.fade > 0 ? value * smooth_step(x / parameters_.fade) : value;
}

// All three are `depth` deep in the middle and nothing at their ends. vee and joint have a kink
// there, on purpose: it is what makes a wheel strike.
double Irregularity::dip(double x) const {
  const IrregularityParameters& p = parameters_;
  const double s = std::abs(x - p.at) / (p.length / 2);  // 0 in the middle, 1 at both ends
  if (s >= 1) return 0;
  switch (p.kind) {
    case IrregularityKind::vee:
      return -p.depth * (1 - s);
    case IrregularityKind::joint:
      return -p.depth * (1 - s) * (1 - s);
    default:
      return -p.depth * (1 + std::cos(std::numbers::pi * s)) / 2;
  }
}

// Upwards, so that a dip is negative.
double Irregularity::at(double x) const {
  const IrregularityParameters& p = parameters_;
  const double behind = (x - p.at) / p.length;  // waves
  switch (p.kind) {
    case IrregularityKind::none:
      return 0;
    case IrregularityKind::spectrum:
    case IrregularityKind::file:
      return sampled(x);
    case IrregularityKind::waves:
      if (behind <= 0 || behind >= static_cast<double>(p.waves)) return 0;
      return -p.depth * (1 - std::cos(two_pi * behind)) / 2;
    default:
      return dip(x);
  }
}

}  // namespace trackbed::track
