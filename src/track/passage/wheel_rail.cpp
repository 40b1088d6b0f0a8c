// Hertzian elliptic contact without tables: the ratio of the half axes follows from one equation in
// complete elliptic integrals, which are computed to rounding by the arithmetic-geometric mean.
//   A = 1/(2 R_wheel), B = 1/(2 R_rail) (the larger is B),  e^2 = 1 - b^2/a^2,
//   B/A = (E/(1 - e^2) - K)/(K - E)              -> e
//   a^3 = 3 F (K - E)/(2 pi E* e^2 A),   delta = 3 F K/(2 pi a E*),   1/E* = 2 (1 - nu^2)/E
// (Johnson 1985, Contact Mechanics, section 4.2, doi:10.1017/CBO9781139171731.)
// Rejected: Hertz's table of m and n, whose four digits limit the accuracy of C_H.
#include "trackbed/track/wheel_rail.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trackbed::track {

namespace {

// Complete elliptic integrals of the first and second kind, K and E; their difference is computed
// directly, since near a circle a subtraction would lose its digits.
struct Elliptic {
  double k, k_less_e;
};

// From the parameter m = e^2 by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
Elliptic elliptic(double m) {
  double a = 1, b = std::sqrt(1 - m), c = std::sqrt(m), power = 0.5, sum = power * c * c;
  constexpr int most = 40;  // a and b may remain different by rounding
  for (int k = 0; k < most && std::abs(c) > 1e-16 * a; ++k) {
    const double mean = (a + b) / 2;
    c = (a - b) / 2;
    b = std::sqrt(a * b);
    a = mean;
    power *= 2;
    sum += power * c * c;
  }
  const double k = std::numbers::pi / (2 * a);
  return {k, k * sum};
}

// Ratio of curvatures for an ellipse of parameter m; increases from 1 to infinity.
double curvature_ratio(double m) {
  const Elliptic i = elliptic(m);
  return (m * i.k - i.k_less_e) / ((1 - m) * i.k_less_e);
}

// By bisection: the function is monotone, and it is evaluated once per run.
double parameter_of(double ratio) {
  double low = 1e-12, high = 1 - 1e-12;  // nearly a circle (exactly: 0/0); nearly a line
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (curvature_ratio(middle) < ratio ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

//   p0 = 3 F/(2 pi a b)
double HertzContact::pressure(double force) const {
  return 3 * std::cbrt(force) / (2 * std::numbers::pi * half_axis_a * half_axis_b);
}

// For F = 1 N: half axes are proportional to F^(1/3), the approach to F^(2/3).
HertzContact hertz_contact(const HertzBodies& bodies) {
  const double one = 1 / (2 * bodies.wheel_radius), other = 1 / (2 * bodies.rail_radius);
  const double a_curvature = std::min(one, other), b_curvature = std::max(one, other);
  const double modulus = bodies.young / (2 * (1 - bodies.poisson * bodies.poisson));
  const double m = parameter_of(b_curvature / a_curvature);
  const Elliptic i = elliptic(m);
  HertzContact contact;
  contact.half_axis_a =
      std::cbrt(3 * i.k_less_e / (2 * std::numbers::pi * modulus * m * a_curvature));
  contact.half_axis_b = contact.half_axis_a * std::sqrt(1 - m);
  const double unit = 3 * i.k / (2 * std::numbers::pi * contact.half_axis_a * modulus);
  contact.constant = std::pow(unit, -1.5);
  return contact;
}

namespace {

// Pa; N/m^1.5. Far softer than real contacts; with a millionth of it the static equilibrium of a
// train does not converge.
constexpr double softest = 1e3;

}  // namespace

// The linear law is for comparison with closed forms, and as the spring of a sprung mass.
void WheelRailParameters::declare(input::Section& s) {
  s.choice("law", law, {"hertz", "linear"},
           "Contact law of wheel and rail, for compression only; hertz: F = C * approach^1.5; "
           "linear: F = stiffness * approach.");
  s.number("wheel_radius", bodies.wheel_radius, {.unit = "m", .above = 0, .usually_to = 1},
           "Rolling radius of the wheels (hertz).");
  s.number("rail_radius", bodies.rail_radius,
           {.unit = "m", .above = 0, .usually_from = 0.01, .usually_to = 1},
           "Radius of the rail head across the track (hertz).");
  s.number("young", bodies.young, {.unit = "Pa", .at_least = softest, .usually_from = 1e9},
           "Young's modulus of wheel and rail in their contact (hertz).");
  s.number("poisson", bodies.poisson, {.above = -1, .at_most = 0.5},
           "Poisson's ratio of wheel and rail in their contact (hertz).");
  s.number("constant", constant, {.unit = "N/m^1.5", .at_least = 0, .usually_from = 1e10},
           "Constant C of F = C * approach^1.5 (hertz), 0 or at least 1000 N/m^1.5; 0: from radii "
           "and moduli.");
  s.number("stiffness", stiffness, {.unit = "N/m", .above = 0},
           "Contact stiffness of one wheel on one rail (linear).");
  s.integer("flat_axle", flat_axle, {.at_least = 0, .at_most = 10000},
            "Number of the axle whose wheels have a flat (the first is 1); 0: none.");
  s.number("flat_length", flat_length, {.unit = "m", .above = 0, .usually_to = 0.2},
           "Length of the flat, which has rounded edges and the depth length^2/(16 * "
           "wheel_radius).");
  s.number("flat_at", flat_at, {.unit = "m"},
           "An x where the middle of the flat touches the rail; it also touches the rail at every "
           "whole number of wheel circumferences before and beyond this x.");
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"law", "constant", "stiffness"}};
  s.rule("stiffness", law == WheelRailLaw::linear || stiffness == WheelRailParameters().stiffness,
         "has no effect with law = \"hertz\"", about);
  s.rule("constant", law == WheelRailLaw::hertz || constant == 0,
         "has no effect with law = \"linear\"", about);
  s.rule("constant", constant == 0 || constant >= softest,
         fmt::format("must be 0 or at least {:g} N/m^1.5: a softer contact does not converge",
                     softest),
         {.reads = {"constant"}});
  const WheelRailParameters none;
  const auto of_flat = [&](const char* name, bool given) {
    s.rule(name, flat_axle > 0 || !given, "has no effect: no axle has a flat (flat_axle)",
           {.severity = input::Severity::warning, .reads = {"flat_axle", name}});
  };
  of_flat("flat_length", flat_length != none.flat_length);
  of_flat("flat_at", flat_at != none.flat_at);
  s.rule("flat_length", flat_axle == 0 || flat_length <= bodies.wheel_radius,
         fmt::format("must be at most the radius of the wheel ({:g} m)", bodies.wheel_radius),
         {.reads = {"flat_axle", "flat_length", "wheel_radius"}});
}

// The law is selected once: a step evaluates some dozen forces.
WheelRail::WheelRail(const WheelRailParameters& p)
    : law_(p.law),
      constant_(p.law == WheelRailLaw::linear ? p.stiffness
                : p.constant > 0              ? p.constant
                                              : hertz_contact(p.bodies).constant),
      flat_axle_(p.flat_axle),
      flat_length_(p.flat_length),
      flat_at_(p.flat_at),
      radius_(p.bodies.wheel_radius) {}

double WheelRail::force(double approach) const {
  if (approach <= 0) return 0;
  return constant_ * (law_ == WheelRailLaw::linear ? approach : approach * std::sqrt(approach));
}

// A flat with rounded edges lowers the wheel by
//   d/2 (1 + cos(2 pi s/l)),   d = l^2/(16 R),   |s| < l/2,
// s the distance from the flat's middle, l its length, m (Newton, Clark 1979,
// doi:10.1243/JMES_JOUR_1979_021_046_02). As a static profile: the rotation of the wheel about a
// sharp edge is not modelled.
double WheelRail::flat(std::size_t axle, double x) const {
  if (flat_axle_ < 1 || axle + 1 != static_cast<std::size_t>(flat_axle_)) return 0;
  const double turn = 2 * std::numbers::pi * radius_;
  const double s = std::remainder(x - flat_at_, turn);
  if (std::abs(s) >= flat_length_ / 2) return 0;
  const double depth = flat_length_ * flat_length_ / (16 * radius_);
  return depth / 2 * (1 + std::cos(2 * std::numbers::pi * s / flat_length_));
}

// The tangent stiffness k_H = dF/d(approach), N/m.
double WheelRail::slope(double approach) const {
  if (approach <= 0) return 0;
  return law_ == WheelRailLaw::linear ? constant_ : 1.5 * constant_ * std::sqrt(approach);
}

// For compressive forces only.
double WheelRail::approach(double force) const {
  const double ratio = force / constant_;
  return law_ == WheelRailLaw::linear ? ratio : std::pow(ratio, 2.0 / 3);
}

}  // namespace trackbed::track
