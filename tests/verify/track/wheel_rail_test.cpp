// Hertzian wheel-rail contact, and the irregularities of the rail.
#include "trackbed/track/wheel_rail.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/verified.hpp"
#include "trackbed/track/irregularity.hpp"

namespace trackbed::track::wheel_rail_test {
namespace {

TEST(Hertz, WheelOfHalfAMetreOnARail) {
  const auto digits = [](double last) {
    return verified::Tolerance{0.6 * last, "five digits of the reference"};
  };
  const HertzContact contact = hertz_contact({});
  const WheelRail law((WheelRailParameters()));
  const double force = 76e3, approach = law.approach(force);
  verified::near("C_H", "N/m^1.5", contact.constant, 9.4125e10, digits(1e6));
  verified::near("approach at 76 kN", "m", approach, 86.711e-6, digits(1e-9));
  verified::near("k_H at 76 kN", "N/m", law.slope(approach), 1.3147e9, digits(1e5));
  verified::near("p0 at 76 kN", "Pa", contact.pressure(force), 1129.4e6, digits(1e5));
}

// References: Hertz's integrals over the depth w (Johnson 1985, equation 3.59 and 3.60),
//   d = c I(0,0),  A = c I(1,0),  B = c I(0,1),  c = 3 F/(4 pi E*)
//   I(m,n) = int_0^inf (a^2 + w)^(-m-1/2) (b^2 + w)^(-n-1/2) w^(-1/2) dw
// by quadrature with 40 digits (mpmath), without elliptic integrals.
TEST(Hertz, ConstantAgreesWithHertzsIntegrals) {
  const std::vector<std::tuple<double, double, double>> cases = {{0.46, 0.3, 94125079189.525359},
                                                                 {0.5, 0.3, 96263563401.656411},
                                                                 {0.3, 0.3, 84265008846.9486328},
                                                                 {0.46, 0.08, 71641014356.0366233},
                                                                 {3, 0.3, 166186055392.236063}};
  const verified::Tolerance rounding{
      1e-9, "elliptic integrals of a parameter known to 1e-12, and rounding"};
  for (const auto& [wheel, rail, reference] : cases)
    verified::near(fmt::format("C_H of radii of {:g} and {:g} m", wheel, rail), "N/m^1.5",
                   hertz_contact({.wheel_radius = wheel, .rail_radius = rail}).constant, reference,
                   rounding.of(reference));
}

// Equal radii: a sphere on a plane, C = 4/3 E* sqrt(R) with 1/E* of two bodies and R = the radius
// of the equivalent sphere.
TEST(Hertz, EqualRadiiAreASphere) {
  const HertzBodies bodies{.wheel_radius = 0.4, .rail_radius = 0.4};
  const double modulus = bodies.young / (2 * (1 - bodies.poisson * bodies.poisson));
  const double sphere = 4.0 / 3 * modulus * std::sqrt(0.4);
  const verified::Tolerance nearly{1e-9, "the ellipse's parameter ends at 1e-12 instead of 0"};
  verified::near("C_H, crossed cylinders", "N/m^1.5", hertz_contact(bodies).constant, sphere,
                 nearly.of(sphere));
}

// Also for radii in other units, about which `check` warns. The longer the ellipse the softer the
// contact.
TEST(Hertz, ConvergesForAnyRatioOfRadii) {
  double last = 1e300;
  for (double ratio = 1; ratio < 1e7; ratio *= 1.03) {
    const double found = hertz_contact({.wheel_radius = 0.3 * ratio}).constant;
    EXPECT_NEAR(hertz_contact({.wheel_radius = 0.3, .rail_radius = 0.3 * ratio}).constant, found,
                1e-9 * found);
    // With equal curvature across the longer axis, so that only the ellipse changes.
    EXPECT_LT(found / std::sqrt(ratio), last);
    last = found / std::sqrt(ratio);
  }
}

TEST(Irregularities, RootMeanSquareInD1) {
  const std::vector<std::tuple<const char*, Spectrum, double, double>> cases = {
      {"ERRI low", Spectrum::erri_low, 0.9843e-3, 5e-8},
      {"ERRI high", Spectrum::erri_high, 1.6109e-3, 5e-8},
      {"FRA 1", Spectrum::fra_1, 8.541e-3, 5e-7},
      {"FRA 6", Spectrum::fra_6, 1.429e-3, 5e-7},
      {"China", Spectrum::china, 0.2864e-3, 5e-8}};
  const verified::Tolerance line{
      0.005, "lines 1 % apart: half of one more or less at the end that has the most power"};
  for (const auto& [name, spectrum, reference, digits] : cases) {
    verified::near(fmt::format("{}, of the spectrum", name), "m", rms_of(spectrum, 3, 25),
                   reference, verified::Tolerance{digits, "four digits of the reference"});
    IrregularityParameters p;
    p.kind = IrregularityKind::spectrum;
    p.spectrum = spectrum;
    verified::near(fmt::format("{}, of the profile's lines", name), "m",
                   Irregularity(p, 100).spectrum_d1_rms(), reference, line.of(reference));
  }
}

// The sampled profile has the power of the spectrum: 20 km of profile, wavelengths of up to 70 m.
TEST(Irregularities, SamplesHaveThePowerOfTheSpectrum) {
  IrregularityParameters p;
  p.kind = IrregularityKind::spectrum;
  p.fade = 0;
  const Irregularity profile(p, 20000);
  double sum = 0;
  const int samples = 100000;
  for (int i = 0; i < samples; ++i) sum += std::pow(profile.at(0.2 * (i + 0.5)), 2);
  const double expected = rms_of(p.spectrum, p.shortest, p.longest);
  const verified::Tolerance sampled{0.03, "300 of the longest waves: 1 / (2 sqrt(300))"};
  verified::near("root mean square over 20 km", "m", std::sqrt(sum / samples), expected,
                 sampled.of(expected));
}

}  // namespace
}  // namespace trackbed::track::wheel_rail_test
