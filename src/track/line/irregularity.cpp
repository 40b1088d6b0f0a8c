// Dips in closed form; spectra as equidistant samples with cubic interpolation, so that evaluation
// takes constant time and the profile is smooth; measured profiles as the rows of their file.
//
// A spectrum is a sum of cosines with random phases on wave numbers with equal spacing in their
// logarithm: each amplitude is exact for the power in its band, so that the root mean square does
// not depend on the phases (Shinozuka and Deodatis 1991, doi:10.1115/1.3119501). The same seed
// gives the same profile on any machine and number of ranks. Rejected: filtered noise and inverse
// Fourier transform, which tie the profile to its length.
#include "trackbed/track/irregularity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "track/line/band.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::track {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
constexpr int lines = 400;
constexpr double samples_per_wave = 20;
const std::vector<std::string_view> kind_words = {"none",  "versine",  "vee",  "joint",
                                                  "waves", "spectrum", "file", "same"};
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

// Relative difference of two neighbouring row distances up to which they count as equal.
constexpr double even_within = 0.1;

// Cubic with given values (m) and slopes at both ends of a stretch of `length` m, t from 0 to 1.
double hermite(double t, double length, std::array<double, 2> value, std::array<double, 2> slope) {
  const double left = 1 - t;
  return left * left * (1 + 2 * t) * value[0] + t * t * (3 - 2 * t) * value[1] +
         t * left * length * (left * slope[0] - t * slope[1]);
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

std::string_view word_of(IrregularityKind kind) {
  return kind_words[static_cast<std::size_t>(kind)];
}

// Each kind uses some of these; the descriptions state which.
void IrregularityParameters::declare(input::Section& s) {
  s.choice("kind", kind, kind_words,
           "Shape of the running surface; none: even; versine: a smooth dip; vee: a dip of two "
           "ramps; joint: a dip of two parabolas with a kink; waves: successive smooth dips; "
           "spectrum: random; file: measured; same: that of the left rail.");
  s.number("at", at, {.unit = "m"}, "x of the middle of the dip, or of the start of the waves.");
  s.number("depth", depth, {.unit = "m", .usually_from = -0.02, .usually_to = 0.02},
           "Depth of dip or waves; negative: a bump.");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 200},
           "Length of the dip, or of one wave.");
  s.integer("waves", waves, {.at_least = 1, .at_most = 1e6}, "Number of waves.");
  s.choice("spectrum", spectrum,
           {"erri_low", "erri_high", "fra_1", "fra_2", "fra_3", "fra_4", "fra_5", "fra_6", "china"},
           "Spectrum of the vertical profile after ERRI B176, FRA track classes, or TB/T 3352 "
           "(ballastless).");
  s.number("shortest", shortest, {.unit = "m", .above = 0, .usually_to = 10},
           "Shortest wavelength of the spectrum.");
  s.number("longest", longest, {.unit = "m", .above = 0, .usually_to = 300},
           "Longest wavelength of the spectrum.");
  s.integer("seed", seed, {.at_least = 0}, "Seed of the random profile.");
  s.number(
      "fade", fade, {.unit = "m", .at_least = 0},
      "Distance from the start of the track over which the profile (spectrum or file) fades in.");
  s.file(
      "file", file,
      "CSV of the profile with columns x_m (increasing), z_m (upwards): cubic between equidistant "
      "rows, linear between others; constant before the first and after the last row.");
  s.rule("file", kind != IrregularityKind::file || !file.empty(), "is needed for kind = \"file\"");
  s.rule("longest", longest > shortest,
         fmt::format("must be longer than `shortest` ({:g} m)", shortest));
}

// Closed forms need no samples.
Irregularity::Irregularity(const IrregularityParameters& parameters, double length)
    : parameters_(parameters), length_(length) {
  if (parameters.kind == IrregularityKind::spectrum) draw(length);
  if (parameters.kind == IrregularityKind::file) read();
}

// Slopes are sampled as well: the error of the cubic is (W spacing)^4/384 of a line, below 3e-5.
void Irregularity::draw(double length) {
  const IrregularityParameters& p = parameters_;
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
  spectrum_d1_ = std::sqrt(d1);
}

namespace {

// Problems of a file end with the command that mends the usual ones.
std::vector<std::vector<double>> rows_of(const std::string& path) {
  try {
    return input::read_table(path, {"x_m", "z_m"}, "x_m");
  } catch (const InputError& error) {
    std::vector<std::string> problems = error.problems();
    problems.back() +=
        "; of a recorded level with other units, gaps or two rails, `python3 postproc geometry "
        "FILE -o DIR --irregularity` makes such a file";
    throw InputError(problems);
  }
}

}  // namespace

// The rows are stored unchanged.
void Irregularity::read() {
  auto columns = rows_of(parameters_.file);
  if (columns[0].size() < 2) throw InputError({parameters_.file + ": needs at least two rows"});
  row_ = std::move(columns[0]);
  height_ = std::move(columns[1]);
}

double Irregularity::faded(double x, double value) const {
  return parameters_.fade > 0 ? value * smooth_step(x / parameters_.fade) : value;
}

// Cubic Hermite between samples.
double Irregularity::sampled(double x) const {
  if (x <= 0) return 0;
  const double along = std::min(x / spacing_, static_cast<double>(height_.size() - 1) - 1e-9);
  const auto k = static_cast<std::size_t>(along);
  return faded(x, hermite(along - static_cast<double>(k), spacing_, {height_[k], height_[k + 1]},
                          {slope_[k], slope_[k + 1]}));
}

// Cubic Hermite interpolation between rows. If a row is in the middle of its neighbours, its slope
// is their difference quotient; otherwise, and at both ends, the intervals on its sides end with
// the slopes of their own chords. A cubic through uneven rows would overshoot in the long
// intervals: rows that are far apart mean a straight line.
double Irregularity::measured(double x) const {
  const auto next = std::upper_bound(row_.begin(), row_.end(), x);
  return before_row(static_cast<std::size_t>(next - row_.begin()), x);
}

double Irregularity::before_row(std::size_t next, double x) const {
  if (x <= 0) return 0;
  if (next == 0) return faded(x, height_.front());
  if (next == row_.size()) return faded(x, height_.back());
  const std::size_t k = next - 1;
  const double length = row_[k + 1] - row_[k], chord = (height_[k + 1] - height_[k]) / length;
  const auto slope = [&](std::size_t at) {
    if (at == 0 || at + 1 == row_.size()) return chord;
    const double before = row_[at] - row_[at - 1], behind = row_[at + 1] - row_[at];
    if (std::abs(behind - before) > even_within * std::max(before, behind)) return chord;
    return (height_[at + 1] - height_[at - 1]) / (before + behind);
  };
  return faded(x, hermite((x - row_[k]) / length, length, {height_[k], height_[k + 1]},
                          {slope(k), slope(k + 1)}));
}

// All three have `depth` in the middle and zero at their ends. vee and joint have a kink in the
// middle, which causes the wheel impact.
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
      return sampled(x);
    case IrregularityKind::file:
      return measured(x);
    case IrregularityKind::waves:
      if (behind <= 0 || behind >= static_cast<double>(p.waves)) return 0;
      return -p.depth * (1 - std::cos(two_pi * behind)) / 2;
    default:
      return dip(x);
  }
}

// Without the length over which spectrum or file fade in.
double Irregularity::d1_rms() const {
  constexpr double step = 0.1;  // m
  const bool fades =
      parameters_.kind == IrregularityKind::spectrum || parameters_.kind == IrregularityKind::file;
  const double begin = fades && parameters_.fade < length_ ? parameters_.fade : 0;
  std::vector<double> heights;
  for (double x = begin + step / 2; x < length_; x += step) heights.push_back(at(x));
  return band_rms(std::move(heights), step, d1_shortest, d1_longest);
}

double Irregularity::samples_for(double shortest, double length) {
  return samples_per_wave * length / shortest;
}

}  // namespace trackbed::track
