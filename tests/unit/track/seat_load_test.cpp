// The load on a rail seat under passing axles, against values of a locomotive on a main line.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::track::seat_load_test {
namespace {

constexpr double spacing = 0.6;     // m
constexpr double rounding = 1e-12;  // relative, a few operations in double precision
constexpr double v = 67.2 / 3.6;    // m/s

SeatLoadParameters locomotive() {
  SeatLoadParameters p;
  p.axles = {0, 2.8, 9.0, 11.8};
  p.speed = v;
  return p;
}

TEST(SeatLoad, SingleAxleGivesTheSeatLoadOfAWinklerBed) {
  // On a Winkler bed with spacing a the seat below the load carries the fraction b a / 2: 0.4628,
  // so that a seat load of 71.1 kN corresponds to 153.64 kN on the rail. Both are rounded to 4
  // digits.
  SeatLoadParameters p = locomotive();
  p.axles = {0};
  const SeatLoad load(p, spacing);
  const double fraction = p.decay * spacing / 2;
  EXPECT_NEAR(fraction, 0.4628, 5e-5);
  EXPECT_NEAR(load.at(0, 0) / fraction, 153.64e3, 10);
  EXPECT_NEAR(load.at(0, 0), 71.1e3, 71.1e3 * rounding);
  // All seats together carry the load: sampling the smooth kernel every 0.6 m changes it by < 2 %.
  double sum = 0;
  for (int i = -50; i <= 50; ++i) sum += load.at(i * spacing, 0);
  EXPECT_NEAR(sum, 153.64e3, 0.02 * 153.64e3);
}

// Chen et al. 2023 (doi:10.1016/j.compgeo.2022.105105), equations 4 to 9 with table 2, for three of
// their trains: axle load (t), speed (km/h), dynamic wheel load and seat load (kN), pressure below
// a sleeper of 0.29 m by 2.5 m (kPa), delay from sleeper to sleeper (ms), of six digits.
TEST(SeatLoad, WheelLoadsGivePublishedPressures) {
  struct Case {
    double tonnes, kmh, wheel, seat, pressure, delay;
  };
  for (const Case& c :
       {Case{25, 120, 201.661, 80.664, 667.57, 18.00}, Case{17, 60, 110.257, 44.103, 364.99, 36.00},
        Case{20, 150, 177.136, 70.854, 586.38, 14.40}}) {
    constexpr double width = 0.29, effective = 2.5 / 3, safety = 2, digits = 1e-5;
    SeatLoadParameters p;
    p.kind = SeatLoadKind::power;
    p.axles = {0};
    p.speed = c.kmh / 3.6;
    p.wheel_load = c.tonnes / 2 * 1e3 * 9.81;
    p.wheel_diameter = 0.97;
    p.slice = safety * 0.3 / effective;  // a slice of 0.3 m
    EXPECT_NEAR(p.dynamic_wheel_load(), 1e3 * c.wheel, digits * 1e3 * c.wheel);
    EXPECT_NEAR(p.largest_seat_load(), 1e3 * c.seat, digits * 1e3 * c.seat);
    const SeatLoad load(p, spacing);
    EXPECT_NEAR(load.at(0, 0) / (0.3 * width), 1e3 * c.pressure, 3 * digits * 1e3 * c.pressure);
    EXPECT_NEAR(load.at(spacing, c.delay / 1e3), load.at(0, 0), rounding * load.at(0, 0));
  }
}

TEST(SeatLoad, AxleLoadsCorrespondToThePeak) {
  SeatLoadParameters p = locomotive();
  p.start = -3;
  const std::vector<AxleLoad> axles = SeatLoad(p, spacing).axles(0.5);
  ASSERT_EQ(axles.size(), 4u);
  for (std::size_t k = 0; k < axles.size(); ++k) {
    EXPECT_NEAR(axles[k].x, -3 + v * 0.5 - p.axles[k], rounding * 20);
    EXPECT_NEAR(axles[k].force, 153.64e3, 10);
  }
}

TEST(SeatLoad, PeakOfThePassageIsThatOfAnAxle) {
  const SeatLoad load(locomotive(), spacing);
  double peak = 0;
  for (int k = 0; k < 20000; ++k) peak = std::max(peak, load.at(6, k * 1e-4));
  // Neighbours 2.8 m away reduce it by 1.7 % (uplift).
  EXPECT_LT(peak, 71.1e3);
  EXPECT_GT(peak, 0.98 * 71.1e3);
}

// A table of both seats: their sum, and the load of the left one minus half of it.
TEST(SeatLoad, BothSeatsHaveTheirColumns) {
  const std::string path = testing::TempDir() + "both_seats.csv";
  std::ofstream(path) << "time_s,sleeper_0_left,sleeper_0_right,sleeper_1_left,sleeper_1_right\n"
                         "0,0,0,0,0\n1,4000,1000,100,700\n";
  SeatLoadParameters p;
  p.kind = SeatLoadKind::seats;
  p.file = path;
  p.gauge = 1.5;
  const SeatLoad load(p, spacing, 2);
  EXPECT_DOUBLE_EQ(load.at(0, 0.5, 0), 2500);
  EXPECT_DOUBLE_EQ(load.left_excess(0.5, 0), 750);
  EXPECT_DOUBLE_EQ(load.at(0.6, 1, 1), 800);
  EXPECT_DOUBLE_EQ(load.left_excess(1, 1), -300);
  EXPECT_EQ(load.left_excess(1.1, 0), 0);
  EXPECT_EQ(SeatLoad(locomotive(), spacing).left_excess(0.1, 0), 0);
}

TEST(SeatLoad, NextSleeperHasTheSameLoadLater) {
  const double shift = spacing / v;
  EXPECT_NEAR(shift, 32.14e-3, 5e-6);
  for (const SeatLoadKind kind : {SeatLoadKind::winkler, SeatLoadKind::power}) {
    SeatLoadParameters p = locomotive();
    p.kind = kind;
    const SeatLoad load(p, spacing);
    for (double t = 0; t < 1; t += 0.01)
      EXPECT_NEAR(load.at(1.2 + spacing, t + shift), load.at(1.2, t), 71.1e3 * rounding);
  }
}

TEST(SeatLoad, PowerFallsToItsRatioOneSleeperAway) {
  SeatLoadParameters p = locomotive();
  p.kind = SeatLoadKind::power;
  p.axles = {0};
  const SeatLoad load(p, spacing);
  EXPECT_NEAR(load.at(spacing, 0) / load.at(0, 0), p.ratio, rounding);
  EXPECT_NEAR(load.at(2 * spacing, 0) / load.at(0, 0), std::pow(p.ratio, 4), rounding);
}

TEST(SeatLoad, StartAndDurationCoverThePassage) {
  SeatLoadParameters p = locomotive();
  p.start = -5;
  const SeatLoad load(p, spacing);
  EXPECT_NEAR(load.at(0, 5 / v), SeatLoad(locomotive(), spacing).at(0, 0), 71.1e3 * rounding);
  EXPECT_NEAR(load.duration(16.2), (16.2 + 3 + 11.8 + 5) / v, rounding);
  EXPECT_LT(std::abs(load.at(16.2, load.duration(16.2))), 0.02 * 71.1e3);
}

// |Fourier transform| of the load at one sleeper, by the trapezoidal rule (smooth: converges fast).
double spectrum(const SeatLoad& load, double frequency) {
  constexpr double step = 2e-4, x = 10;  // s, m
  std::complex<double> sum = 0;
  for (int k = 0; k < 8000; ++k)
    sum += load.at(x, k * step) * std::polar(1.0, -2 * std::numbers::pi * frequency * k * step);
  return std::abs(sum) * step;
}

double local_maximum(const std::function<double(double)>& f, double from, double to) {
  double best = from;
  for (double x = from; x <= to; x += 0.005)
    if (f(x) > f(best)) best = x;
  return best;
}

TEST(SeatLoad, SpectrumPeaksAtBogieDistanceAndWheelbase) {
  // Divided by the spectrum of one axle, which leaves the effect of the axle positions: 1 % covers
  // the 0.005 Hz raster and the shift of the peak of cos(pi f 9/v) by cos(pi f 2.8/v).
  SeatLoadParameters one = locomotive(), pair = locomotive(), bogies = locomotive();
  one.axles = {0}, pair.axles = {0, 2.8}, bogies.axles = {0, 9.0};
  const SeatLoad single(one, spacing), wheels(pair, spacing), centres(bogies, spacing);
  const auto over_single = [&](const SeatLoad& load) {
    return [&](double f) { return spectrum(load, f) / spectrum(single, f); };
  };
  EXPECT_NEAR(local_maximum(over_single(centres), 1.2, 3), 2.07, 0.01 * 2.07);
  EXPECT_NEAR(local_maximum(over_single(wheels), 5, 8), 6.67, 0.01 * 6.67);
}

TEST(SeatLoad, SpectrumOfThePassageIsKernelTimesPattern) {
  // 8 b^3/(k^4 + 4 b^4) is the transform of the kernel over s, with k = 2 pi f/v.
  const SeatLoadParameters p = locomotive();
  const SeatLoad passage(p, spacing);
  for (const double f : {0.0, 1.0, v / 9, 4.0, v / 2.8, 9.0}) {
    const double pi = std::numbers::pi, k = 2 * pi * f / v, b = p.decay;
    const double kernel = 8 * std::pow(b, 3) / (std::pow(k, 4) + 4 * std::pow(b, 4));
    const double pattern = 4 * std::abs(std::cos(pi * f * 2.8 / v) * std::cos(pi * f * 9 / v));
    constexpr double kink = 1e-4;  // of the largest: time raster at the kernel's third derivative
    EXPECT_NEAR(spectrum(passage, f), p.peak * kernel * pattern / v, kink * p.peak * 8 / b / v)
        << f;
  }
}

class SeatTable : public ::testing::Test {
 protected:
  SeatLoadParameters written(const std::string& rows) {
    std::ofstream("seat_table.csv") << "time_s,force_N\n" << rows;
    SeatLoadParameters p;
    p.kind = SeatLoadKind::table;
    p.file = "seat_table.csv";
    p.speed = 20;
    return p;
  }
};

TEST_F(SeatTable, IsLinearBetweenRowsAndZeroOutside) {
  const SeatLoad load(written("0,0\n0.1,1000\n0.3,3000\n0.4,0\n"), spacing);
  EXPECT_NEAR(load.at(0, 0.05), 500, 500 * rounding);
  EXPECT_NEAR(load.at(0, 0.2), 2000, 2000 * rounding);
  EXPECT_EQ(load.at(0, 0.1), 1000);
  EXPECT_EQ(load.at(0, -0.01), 0);
  EXPECT_EQ(load.at(0, 0.41), 0);
  EXPECT_NEAR(load.at(10, 0.7), 2000, 2000 * rounding);  // 0.5 s later
  EXPECT_NEAR(load.duration(10), 0.9, rounding);
}

TEST(SeatsOfTheirOwn, EachSleeperHasAColumn) {
  std::ofstream("seats.csv") << "time_s,sleeper_1,sleeper_0\n0,0,5\n0.5,10,5\n";
  SeatLoadParameters p;
  p.kind = SeatLoadKind::seats;
  p.file = "seats.csv";
  const SeatLoad load(p, spacing, 2);
  EXPECT_EQ(load.at(0, 0.25, 0), 5);
  EXPECT_EQ(load.at(0.6, 0.25, 1), 5);  // not later: the table has its own times
  EXPECT_EQ(load.at(0.6, 0.5, 1), 10);
  EXPECT_EQ(load.at(0, 0.51, 0), 0);
  EXPECT_EQ(load.duration(10), 0.5);
  EXPECT_THROW(SeatLoad(p, spacing, 3), InputError);  // no column for the third
}

TEST_F(SeatTable, TimesMustRise) {
  const SeatLoadParameters p = written("0,0\n0.2,1\n0.1,2\n");
  try {
    const SeatLoad load(p, spacing);
    FAIL() << "a table with decreasing times was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(error.problems().at(0).find("seat_table.csv:4: time_s must increase"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(SeatTable, OneRowIsNotATable) {
  const SeatLoadParameters p = written("0,5\n");
  EXPECT_THROW(SeatLoad(p, spacing), InputError);
}

}  // namespace
}  // namespace trackbed::track::seat_load_test
