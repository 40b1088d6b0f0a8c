// Vertical irregularity of the rail's running surface: height (m) above the straight line along x.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"

namespace trackbed::track {

// Vertical profile, one-sided power spectral density.
enum class Spectrum { erri_low, erri_high, fra_1, fra_2, fra_3, fra_4, fra_5, fra_6, china };
// m^2/(rad/m) at the wave number (rad/m).
double density_of(Spectrum spectrum, double wave_number);
// m, root mean square of the irregularity between two wavelengths (m).
double rms_of(Spectrum spectrum, double shortest, double longest);

// versine: smooth; vee: two straight ramps; joint: two parabolas with a kink between them, as at a
// weld or joint; waves: versines one after the other; same: the right rail has the irregularity of
// the left one.
enum class IrregularityKind { none, versine, vee, joint, waves, spectrum, file, same };
std::string_view word_of(IrregularityKind kind);  // as in decks

struct IrregularityParameters {
  IrregularityKind kind = IrregularityKind::none;
  double at = 30;       // m, middle of a dip, start of waves
  double depth = 1e-3;  // m, below the line
  double length = 1;    // m, of a dip or of one wave
  std::int64_t waves = 1;
  Spectrum spectrum = Spectrum::erri_low;
  double shortest = 1, longest = 70;  // m, wavelengths of the spectrum
  std::int64_t seed = 1;
  double fade = 10;       // m from the start of the track over which spectrum and file fade in
  std::string file = {};  // CSV
  void declare(input::Section& s);
};

class Irregularity {
 public:
  // Defined for x from 0 to `length` m; zero before it and constant beyond it. Throws InputError
  // for an invalid file.
  Irregularity(const IrregularityParameters& parameters, double length);
  double at(double x) const;  // m, upwards
  // m, x and height of each row of a file, unchanged.
  const std::vector<double>& rows() const { return row_; }
  const std::vector<double>& heights() const { return height_; }
  // m, at(x) of a file without the search; `next` is the number of the first row behind x.
  double before_row(std::size_t next, double x) const;
  // Number of samples of a spectrum with this shortest wavelength on a track of `length` m.
  static double samples_for(double shortest, double length);
  // m, root mean square for wavelengths of 3 to 25 m (D1 of EN 13848-1) on the track beyond
  // `fade`, by a Butterworth filter of fourth order.
  double d1_rms() const;
  // m, expected value of the same for the spectrum: from the power of the lines between 3 and 25 m.
  double spectrum_d1_rms() const { return spectrum_d1_; }

 private:
  void draw(double length);
  void read();
  double faded(double x, double value) const;
  double sampled(double x) const;
  double measured(double x) const;
  double dip(double x) const;
  IrregularityParameters parameters_;
  double length_, spacing_ = 0, spectrum_d1_ = 0;  // m
  std::vector<double> row_;                        // m, x of the heights of a file
  std::vector<double> height_, slope_;             // m, -
};

}  // namespace trackbed::track
