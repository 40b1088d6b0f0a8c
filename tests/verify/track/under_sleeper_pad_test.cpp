// Under-sleeper pads: two Kelvin elements in series against their closed forms, static, harmonic
// and in time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/SparseLU>
#include <cmath>
#include <complex>
#include <numbers>

#include "support/verified.hpp"
#include "trackbed/core/types.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::under_sleeper_pad_test {
namespace {

constexpr std::size_t middle = 20;  // of 41 sleepers, far from the run-in
constexpr double pad = 80e6, pad_damper = 30e3;

// Of sleepers without rail pads, each on its own.
const verified::Tolerance rounding{1e-13, "springs in series: rounding, 1e-16 a few times"};

// Sleepers without rail pads, on ballast only.
LineParameters bare(Dimension dimension = Dimension::plane) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 24;
  p.pads = false;
  p.under_sleeper = {.stiffness = pad, .damping = pad_damper};
  return p;
}

Vector on(const Line& line, std::size_t sleeper, double left, double right = 0) {
  Vector force = Vector::Zero(line.system().mass.rows());
  force[line.sleeper_unknown(sleeper, 0)] = left;
  if (line.sides() == 2) force[line.sleeper_unknown(sleeper, 1)] = right;
  return force;
}

double static_compliance(const LineParameters& p, std::size_t sleeper = middle) {
  const Line line(p);
  const Vector u = Statics(line.system()).flexibility(on(line, sleeper, 1));
  return u[line.sleeper_unknown(sleeper)];
}

TEST(UnderSleeperPad, StaticSpringsInSeries) {
  LineParameters p = bare();
  const double two = 1 / pad + 1 / p.ballast.stiffness;
  verified::near("sleeper on pad and ballast", "m/N", static_compliance(p), two, rounding.of(two));
  p.ballast.mass = 300;
  const double three = two + 1 / p.ballast.below_stiffness;
  verified::near("on pad, ballast and the spring below its mass", "m/N", static_compliance(p),
                 three, rounding.of(three));
  p.under_sleeper.from = 12.3;
  verified::near("before the first pad", "m/N", static_compliance(p), three - 1 / pad,
                 rounding.of(three));
  verified::near("behind it", "m/N", static_compliance(p, middle + 1), three, rounding.of(three));
  p.under_sleeper = {.stiffness = pad, .to = 12};
  verified::near("at the end of the pads", "m/N", static_compliance(p), three - 1 / pad,
                 rounding.of(three));
}

// Zones apply to the ballast: half its stiffness below the same pad.
TEST(UnderSleeperPad, KeepsItsStiffnessInZones) {
  LineParameters p = bare();
  p.track.zones = {{.from = 11.9, .to = 12.1, .bed = 0.5}};
  const double series = 1 / pad + 2 / p.ballast.stiffness;
  verified::near("sleeper on pad and half the ballast", "m/N", static_compliance(p), series,
                 rounding.of(series));
}

// Uniform pads and ballast k_s (of a rail seat) over the length L have the roll stiffness
// 2 k_s L^2/12.
TEST(UnderSleeperPad, ResistsRoll) {
  const LineParameters p = bare(Dimension::space);
  const Line line(p);
  const Vector u = Statics(line.system()).flexibility(on(line, middle, 1, -1));
  const double moment = p.track.gauge, series = 1 / (1 / pad + 1 / p.ballast.stiffness);
  const double length = p.track.sleeper_length, turn = 6 * moment / (series * length * length);
  const double found =
      (u[line.sleeper_unknown(middle, 0)] - u[line.sleeper_unknown(middle, 1)]) / p.track.gauge;
  verified::near("roll per pair of forces on the rails' seats", "rad/N", found, turn,
                 rounding.of(turn));
}

using Complex = std::complex<double>;

// Of half a sleeper: 1/(k - m w^2), with complex springs k = k' + i w c in series.
Complex receptance(const LineParameters& p, double w) {
  const auto spring = [w](double k, double c) { return Complex(k, w * c); };
  const Complex below = spring(p.ballast.stiffness, p.ballast.damping);
  const Complex series = 1.0 / (1.0 / spring(pad, pad_damper) + 1.0 / below);
  return 1.0 / (series - p.track.sleeper_mass / 2 * w * w);
}

TEST(UnderSleeperPad, ReceptanceOfASleeper) {
  const LineParameters p = bare();
  const Line line(p);
  const LinearSystem& of = line.system();
  for (const double hertz : {20.0, 100.0, 500.0}) {
    const double w = 2 * std::numbers::pi * hertz;
    const Eigen::SparseMatrix<Complex> matrix = of.stiffness.cast<Complex>() +
                                                Complex(0, w) * of.damping.cast<Complex>() -
                                                w * w * of.mass.cast<Complex>();
    const Eigen::SparseLU<Eigen::SparseMatrix<Complex>> solver(matrix);
    const Eigen::VectorXcd u = solver.solve(on(line, middle, 1).cast<Complex>().eval());
    const Complex exact = receptance(p, w), found = u[line.sleeper_unknown(middle)];
    verified::near(fmt::format("receptance at {:g} Hz, difference over its size", hertz), "-",
                   std::abs(found - exact) / std::abs(exact), 0, rounding);
  }
}

// Amplitude and phase after the transient has decayed (60 periods of a slowly growing force).
double error_in_time(const LineParameters& p, double step) {
  constexpr double hertz = 100;
  const Line line(p);
  const double w = 2 * std::numbers::pi * hertz;
  const Complex exact = receptance(p, w);
  RailForce force{.size = 1, .frequency = hertz};
  Newmark sleepers(line.system(), step);
  double worst = 0;
  const auto steps = static_cast<int>(std::lround(0.6 / step));
  for (int i = 1; i <= steps; ++i) {
    const double time = i * step;
    sleepers.accept(sleepers.free_change(on(line, middle, force.force(time))));
    if (time < 0.5) continue;
    const double there = (exact * std::polar(1.0, w * time)).imag();
    worst = std::max(worst, std::abs(sleepers.displacement[line.sleeper_unknown(middle)] - there));
  }
  return worst / std::abs(exact);
}

// Also with dampers, for which the height between pad and ballast is an internal variable.
TEST(UnderSleeperPad, IsOfSecondOrderInTheStep) {
  const LineParameters p = bare();
  const double coarse = error_in_time(p, 4e-4), middle_one = error_in_time(p, 2e-4),
               fine = error_in_time(p, 1e-4);
  const verified::Tolerance order{0.05, "second order; next term (omega dt)^2 = 0.06 at 0.4 ms"};
  verified::near("order of steps of 0.4 and 0.2 ms", "-", std::log2(coarse / middle_one), 2, order);
  verified::near("order of steps of 0.2 and 0.1 ms", "-", std::log2(middle_one / fine), 2, order);
  verified::below("error of the sleeper, steps of 0.2 ms, over its amplitude", "-", middle_one,
                  {0.01, "(omega dt)^2 / 12 = 1.3e-3, four times that near its resonance, twice"});
}

// A wheel on a rail over hanging sleepers: the gap closes first, then pad and ballast act like one
// spring with their stiffness in series.
TEST(UnderSleeperPad, BelowAHangingSleeper) {
  VehicleParameters v;
  v.name = "axle", v.kind = VehicleKind::forces, v.length = 1;
  v.axles = {0}, v.loads = {120e3};
  const TrainParameters motion{.vehicles = {"axle"}, .speed = 1e-12, .start = 12};
  const auto seat = [&](const LineParameters& p) {
    const Line line(p);
    const Train train(motion, {v}, 2);
    const Passage passage(line, train, WheelRail({}), Irregularity({}, 24), motion,
                          {.duration = 1});
    return passage.on_sleeper(middle);
  };
  LineParameters padded, soft;
  padded.track.length = soft.track.length = 24;
  padded.track.zones = soft.track.zones = {{.from = 11.9, .to = 12.1, .gap = 0.2e-3}};
  padded.under_sleeper = {.stiffness = pad, .damping = pad_damper};
  soft.ballast.stiffness = 1 / (1 / pad + 1 / soft.ballast.stiffness);
  const double force = seat(padded);
  verified::above("seat over a gap of 0.2 mm", "N", force, {5e3, "separates: the gap is closed"});
  const verified::Tolerance equilibrium{
      1e-7, "static equilibrium to 1e-12 m times 120 MN/m: 1e-4 N of 18 kN, ten times"};
  verified::near("the same on one spring", "N", force, seat(soft), equilibrium.of(force));
}

// Pads a million times as stiff as ballast have no effect, also below hanging sleepers.
TEST(UnderSleeperPad, HardOnesHaveNoEffect) {
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 10};
  IrregularityParameters rough;
  rough.kind = IrregularityKind::spectrum;
  const auto largest = [&](double stiffness) {
    LineParameters p, q;
    for (LineParameters* one : {&p, &q}) {
      one->track.length = 24;
      one->track.zones = {{.from = 11.9, .to = 12.7, .gap = 2e-4}};
    }
    p.under_sleeper = {.stiffness = stiffness, .damping = stiffness / 1e3};
    const Line with(p), without(q);
    const Train train(motion, {}, 2);
    const Irregularity rail(rough, 24);
    Passage a(with, train, WheelRail({}), rail, motion, {}),
        b(without, train, WheelRail({}), rail, motion, {});
    double most = 0;
    for (int i = 0; i < 300; ++i) {
      a.advance(), b.advance();
      most = std::max(most, std::abs(a.wheel_force(0) - b.wheel_force(0)));
    }
    return most;
  };
  const double soft = largest(80e6);
  const verified::Limit compliance{3 * 80e6 / 60e12,
                                   "compliance of pads: 80/60e6 of soft ones, 3 times"};
  verified::below("first wheel over hard pads against none, largest difference", "N",
                  largest(60e12), compliance.of(soft));
  verified::above("over soft ones", "N", soft, {300, "separates: soft pads have an effect"});
}

// Two identical rails are the plane track.
TEST(UnderSleeperPad, TwoRailsAlikeAreThePlaneTrack) {
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 10};
  LineParameters plane;
  plane.track.length = 24;
  plane.ballast.mass = 300;
  plane.under_sleeper = {.stiffness = pad, .damping = pad_damper, .from = 10, .to = 15};
  LineParameters space = plane;
  space.track.dimension = Dimension::space;
  const Line one(plane), two(space);
  const Train half(motion, {}, 2), whole(motion, {}, 2, space.track.gauge);
  IrregularityParameters rough;
  rough.kind = IrregularityKind::spectrum;
  const Irregularity rail(rough, 24);
  Passage a(one, half, WheelRail({}), rail, motion, {}),
      b(two, whole, WheelRail({}), rail, motion, {});
  double most = 0;
  for (int i = 0; i < 500; ++i) {
    a.advance(), b.advance();
    for (std::size_t axle = 0; axle < 4; ++axle)
      most = std::max(most, std::abs(a.wheel_force(axle) - b.wheel_force(2 * axle + 1)));
  }
  verified::below("largest difference of a wheel force", "N", most,
                  {5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"});
}

}  // namespace
}  // namespace trackbed::track::under_sleeper_pad_test
