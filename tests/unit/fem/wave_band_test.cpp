// Frequencies and times of the energy of a wave whose acceleration is a Ricker wavelet.
#include "fem/boundary/wave_band.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "unit/fem/wave.hpp"

namespace trackbed::fem::wave_band_test {
namespace {

// The energy of its velocity over frequency is that of a chi-squared variable with 3 degrees of
// freedom, 4 (f / f_p)^2: 95 % lie below 7.815, half below 2.366.
TEST(WaveBand, HasTheEnergyOfARickerWavelet) {
  const BaseMotion wave(wave_table(par::Comm::self(), "band", {50, 0.03}, 1.0, 0, 5e-4));
  const WaveBand along(wave, 0), up(wave, 2);
  // Tables of the length of the wavelet resolve its frequencies to some per cent.
  EXPECT_NEAR(along.frequency_of(0.95), 50 * std::sqrt(7.815 / 4), 0.5);
  EXPECT_NEAR(along.frequency_of(0.5), 50 * std::sqrt(2.366 / 4), 0.5);
  // Symmetric about its middle.
  EXPECT_NEAR(along.time_of(0.5), 0.03, 1e-4);
  EXPECT_NEAR(along.energy_until(0.03) / along.energy(), 0.5, 0.01);
  EXPECT_NEAR(along.energy_until(1) / along.energy(), 1, 1e-12);
  EXPECT_EQ(up.energy(), 0);
  EXPECT_EQ(up.frequency_of(0.95), 0);
}

// Motion before the ground starts to move does not count.
TEST(WaveBand, BeginsWhenTheGroundIsReleased) {
  const BaseMotion wave(wave_table(par::Comm::self(), "late_half", {50, 0}, 1.0, 0, 5e-4));
  EXPECT_GE(WaveBand(wave, 0).time_of(0), 0);
}

}  // namespace
}  // namespace trackbed::fem::wave_band_test
