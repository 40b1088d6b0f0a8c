// The rail under static and harmonic forces against closed forms: Euler-Bernoulli and Timoshenko
// beams on a Winkler bed, discrete supports, a single span.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::beam_test {
namespace {

constexpr double load = 100e3;  // N
constexpr double middle = 30;   // m

TEST(Winkler, EulerBernoulli) {
  const Line line(winkler(60, BeamTheory::euler, 8));
  const Vector u = at_rest(line, middle, load);
  const auto down = [&](double x) { return -line.at(middle + x).deflection(u); };
  const verified::Tolerance digits{
      6e-10, "digits of the reference, 5e-10 m, and elements, (beta h)^4 / 720 = 9e-8 of 1.2 mm"};
  verified::near("w(0)", "m", down(0), 1.183082e-3, digits);
  verified::near("w(0.6 m)", "m", down(0.6), 0.820362e-3, digits);
  verified::near("w(1.2 m)", "m", down(1.2), 0.325852e-3, digits);
  verified::near("uplift at pi/beta", "m", -down(std::numbers::pi / 1.183082), 5.1126e-5, digits);
  verified::near("M(0)", "N m", line.bending_moment(middle, u), 21131.24,
                 {0.02, "digits of the reference, 0.005, and elements, (beta h)^4 / 120 = 5e-7"});
}

// The element is exact for forces at nodes, but a bed also acts between them.
TEST(Winkler, Timoshenko) {
  const verified::Tolerance mesh{1e-5, "second order in elements of 25 mm, of a bed: 8e-6"};
  const Line line(winkler(60, BeamTheory::timoshenko, 24));
  const Vector u = at_rest(line, middle, load);
  verified::near("w(0)", "m", -line.at(middle).deflection(u), 1.246102e-3, mesh.of(1.246e-3));
  verified::near("M(0)", "N m", line.bending_moment(middle, u), 20760.45, mesh.of(20760.45));
}

TEST(Winkler, TimoshenkoConverges) {
  const auto error = [](std::int64_t elements) {
    const Line line(winkler(60, BeamTheory::timoshenko, elements));
    return std::abs(-line.at(middle).deflection(at_rest(line, middle, load)) / 1.2461022e-3 - 1);
  };
  const double coarse = error(2), middle_one = error(4), fine = error(8);
  verified::below("error with elements of 0.15 m", "-", middle_one,
                  {5e-4, "second order from 8e-6 at 25 mm: 2.9e-4, almost twice"});
  const verified::Tolerance order{0.1,
                                  "second order; next term (beta h)^2 / 3 = 4 % at the coarsest"};
  verified::near("order in element length", "-", std::log2(coarse / middle_one), 2, order);
  verified::near("order in element length, 0.15 and 0.075 m", "-", std::log2(middle_one / fine), 2,
                 order);
}

// Pad and ballast of twice the stiffness in series are the support.
TEST(DiscreteSupports, SeatRatios) {
  const std::vector<std::pair<double, std::vector<double>>> cases = {
      {30e6, {0.3508, 0.2450, 0.0990, 0.0148}}, {60e6, {0.4162, 0.2553, 0.0702, -0.0072}}};
  for (const auto& [support, ratios] : cases) {
    LineParameters p;
    p.rail.theory = BeamTheory::euler;
    p.rail.inertia = 6.6238e6 / p.rail.young;
    p.pad.stiffness = p.ballast.stiffness = 2 * support;
    p.track.run_in = 0;
    const Line line(p);
    const Vector u = at_rest(line, middle, load), rest = Vector::Zero(u.size());
    const std::size_t below = line.nearest_sleeper(middle);
    for (std::size_t i = 0; i < ratios.size(); ++i)
      verified::near(fmt::format("R{}, {:g} MN/m", i, support / 1e6), "-",
                     line.seat_force(below + i, u, rest) / load, ratios[i],
                     {5e-5, "four decimals of the reference"});
    double sum = 0;
    for (std::size_t i = 0; i < line.sleepers(); ++i) sum += line.seat_force(i, u, rest);
    verified::near(fmt::format("sum of seats, {:g} MN/m", support / 1e6), "-", sum / load, 1,
                   {1e-10, "equilibrium: rounding times the condition, 1e5, ten times"});
  }
}

// A single span of two elements, P at any place: exact, also between nodes, through the local
// flexibility. w = P a^2 b^2/(3 E I L) + P a b/(k G A L).
TEST(SingleSpan, DeflectionIsExactBetweenNodes) {
  LineParameters p = span(210e9, 3038.3e-8, 60.21);
  p.rail.theory = BeamTheory::timoshenko;
  p.track.length = 1.2;
  p.track.spacing = 1.2;
  p.track.elements = 2;
  const Line line(p);
  const Beam beam = beam_of(p.rail);
  const verified::Tolerance rounding{1e-11, "exact: rounding times the condition, 1e4, ten times"};
  for (const double a : {0.6, 0.3, 0.85}) {
    const double b = 1.2 - a;
    const double exact =
        load * (a * a * b * b / (3 * beam.bending_stiffness) + a * b / beam.shear_stiffness) / 1.2;
    const RailPoint point = line.at(a);
    verified::near(fmt::format("w under P at {:g} m of 1.2 m", a), "m",
                   -point.deflection(at_rest(line, a, load)) + point.local * load, exact,
                   rounding.of(exact));
  }
}

// E I w'''' + (k + i w c - m w^2) w = F delta(x): w(0) = F/(8 E I l^3), 4 l^4 = (...)/E I, the root
// with both parts positive. In time: the force grows, then sine and cosine are fitted over whole
// periods. Damping suppresses reflections from the ends.
TEST(Winkler, Receptance) {
  LineParameters p = winkler(60, BeamTheory::euler);
  p.track.bed_damping = 50e3;
  const Line line(p);
  const Beam beam = beam_of(p.rail);
  for (const double frequency : {50.0, 145.0, 300.0}) {
    const double w = 2 * std::numbers::pi * frequency;
    const std::complex<double> bed(p.track.bed_stiffness - beam.mass * w * w,
                                   w * p.track.bed_damping);
    const auto root = std::pow(bed / (4 * beam.bending_stiffness), 0.25);
    const auto exact = 1.0 / (8 * beam.bending_stiffness * std::pow(root, 3));
    const int per_period = 200, periods = 30;
    const double dt = 1 / (frequency * per_period);
    Newmark motion(line.system(), dt);
    std::complex<double> sum = 0;
    for (int i = 1; i <= per_period * periods; ++i) {
      Vector force = Vector::Zero(motion.displacement.size());
      line.at(middle).add(std::min(1.0, i / (5.0 * per_period)) * std::cos(w * i * dt), force);
      motion.accept(motion.free_change(force));
      if (i > per_period * (periods - 5))
        sum += line.at(middle).deflection(motion.displacement) * std::polar(1.0, -w * i * dt);
    }
    const auto measured = sum * 2.0 / (5.0 * per_period);
    const verified::Tolerance step{
        5e-4, "200 steps a period: (omega dt)^2 / 12 = 8e-5 of it, up to six times near resonance"};
    verified::near(fmt::format("amplitude of w per F at {:g} Hz", frequency), "m/N",
                   std::abs(measured), std::abs(exact), step.of(std::abs(exact)));
    verified::near(fmt::format("phase at {:g} Hz", frequency), "rad", std::arg(measured),
                   std::arg(exact), step);
  }
}

}  // namespace
}  // namespace trackbed::track::beam_test
