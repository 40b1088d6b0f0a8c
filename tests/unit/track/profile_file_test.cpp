// A measured vertical profile from a file beside the deck.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include "trackbed/core/error.hpp"
#include "trackbed/track/irregularity.hpp"

namespace trackbed::track::profile_file_test {
namespace {

IrregularityParameters from(const std::string& name, const std::string& rows) {
  IrregularityParameters p;
  p.kind = IrregularityKind::file;
  p.fade = 0;
  p.file = name;
  std::ofstream(p.file) << "x_m,z_m\n" << rows;
  return p;
}

// Rows every 0.5 m of a straight slope and a level end: the cubic reproduces the slope.
TEST(ProfileFile, FollowsItsRows) {
  std::string rows;
  for (int i = 0; i <= 40; ++i) rows += fmt::format("{},{}\n", 0.5 * i, i <= 20 ? 1e-4 * i : 2e-3);
  const IrregularityParameters p = from("trackbed_profile.csv", rows);
  const Irregularity profile(p, 20);
  EXPECT_NEAR(profile.at(3), 0.6e-3, 1e-15);
  EXPECT_NEAR(profile.at(3.2), 0.64e-3, 1e-15);
  EXPECT_NEAR(profile.at(15.3), 2e-3, 1e-15);
  EXPECT_EQ(profile.at(-1), 0);
  EXPECT_NEAR(profile.at(25), 2e-3, 1e-9);
  std::filesystem::remove(p.file);
}

// It fades in from zero over `fade`, so that the train does not start on a step.
TEST(ProfileFile, FadesIn) {
  IrregularityParameters p = from("trackbed_level.csv", "0,1e-3\n10,1e-3\n20,1e-3\n");
  p.fade = 4;
  const Irregularity profile(p, 20);
  EXPECT_NEAR(profile.at(1e-9), 0, 1e-12);
  EXPECT_NEAR(profile.at(2), 0.5e-3, 1e-12);
  EXPECT_NEAR(profile.at(4), 1e-3, 1e-12);
  std::filesystem::remove(p.file);
}

// Rows that are far apart where the rail is straight and close elsewhere, as at the end of a
// structure: equal to their polyline with a row each 5 mm, without overshoot in long intervals.
TEST(ProfileFile, UnevenRowsAreTheirPolyline) {
  const std::vector<std::array<double, 2>> points = {{0, 0},     {9, 0},        {9.6, -2e-3},
                                                     {11, 1e-3}, {11.3, -1e-3}, {20, 0}};
  std::string rows, fine;
  for (const auto& [x, z] : points) rows += fmt::format("{},{}\n", x, z);
  const auto line = [&](double x) {
    std::size_t k = 0;
    while (k + 2 < points.size() && x > points[k + 1][0]) ++k;
    const auto [x0, z0] = points[k];
    const auto [x1, z1] = points[k + 1];
    return z0 + (z1 - z0) * (x - x0) / (x1 - x0);
  };
  for (int i = 0; i <= 4000; ++i) fine += fmt::format("{},{}\n", 0.005 * i, line(0.005 * i));
  const IrregularityParameters few = from("trackbed_few.csv", rows),
                               many = from("trackbed_many.csv", fine);
  const Irregularity uneven(few, 20), even(many, 20);
  for (int i = 1; i < 2000; ++i) {
    EXPECT_NEAR(uneven.at(0.01 * i), line(0.01 * i), 1e-15) << 0.01 * i;
    // A cubic rounds the corners within two rows.
    EXPECT_NEAR(even.at(0.01 * i), line(0.01 * i), 1e-5) << 0.01 * i;
  }
  std::filesystem::remove(few.file);
  std::filesystem::remove(many.file);
}

// Equidistant rows with any start are reproduced exactly: a wave of 1 m from rows each 0.25 m, with
// the cubic between them reaching sin(pi/4) (1 + 1/4).
TEST(ProfileFile, EvenRowsNeedNotBeginAtZero) {
  const auto wave = [](double x) { return 1e-3 * std::sin(2 * std::numbers::pi * x); };
  std::string rows;
  for (int i = 0; i < 80; ++i) {
    const double x = 0.125 + 0.25 * i;
    rows += fmt::format("{},{}\n", x, wave(x));
  }
  const IrregularityParameters p = from("trackbed_wave.csv", rows);
  const Irregularity profile(p, 20);
  for (int i = 1; i < 79; ++i)
    EXPECT_NEAR(profile.at(0.125 + 0.25 * i), wave(0.125 + 0.25 * i), 1e-15);
  EXPECT_NEAR(profile.at(10.25), 1e-3 * std::sqrt(0.5) * 1.25, 1e-15);
  std::filesystem::remove(p.file);
}

// The filter passes waves in the band, half the power at its limits, and nothing far from it. The
// 10 m over which waves fade in are excluded.
TEST(ProfileFile, TheFilterPassesD1) {
  const auto d1 = [](double wavelength) {
    std::string rows;
    for (int i = 0; i <= 12000; ++i)
      rows += fmt::format("{:.17g},{:.17g}\n", 0.1 * i,
                          1e-3 * std::cos(2 * std::numbers::pi * 0.1 * i / wavelength));
    IrregularityParameters p = from("trackbed_d1.csv", rows);
    p.fade = 10;
    const double found = Irregularity(p, 1200).d1_rms() / (1e-3 * std::sqrt(0.5));
    std::filesystem::remove(p.file);
    return found;
  };
  EXPECT_NEAR(d1(8), 1, 0.01);
  EXPECT_NEAR(d1(3), std::sqrt(0.5), 0.02);
  EXPECT_NEAR(d1(25), std::sqrt(0.5), 0.02);
  EXPECT_LT(d1(1), 0.02);
  EXPECT_LT(d1(100), 0.02);
}

// Of a profile of 4 km: the power of the spectrum times that of the filter, integrated numerically,
// 1.019 times the value with sharp limits. Short profiles of one spectrum differ.
TEST(ProfileFile, D1IsThatOfTheProfile) {
  IrregularityParameters p;
  p.kind = IrregularityKind::spectrum;
  EXPECT_NEAR(Irregularity(p, 4000).d1_rms(), 1.00314e-3, 0.02e-3);
  const Irregularity one(p, 60);
  p.seed = 2;
  const Irregularity other(p, 60);
  EXPECT_GT(std::abs(one.d1_rms() - other.d1_rms()), 1e-5);
  EXPECT_EQ(one.spectrum_d1_rms(), other.spectrum_d1_rms());
}

TEST(ProfileFile, OneRowIsNoProfile) {
  const IrregularityParameters p = from("trackbed_row.csv", "0,1e-3\n");
  EXPECT_THROW(Irregularity(p, 20), InputError);
  std::filesystem::remove(p.file);
}

}  // namespace
}  // namespace trackbed::track::profile_file_test
