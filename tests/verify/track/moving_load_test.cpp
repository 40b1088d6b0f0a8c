// Moving constant forces: on a Winkler bed against the steady state, on a single span against the
// modal solution.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::moving_load_test {
namespace {

constexpr double static_deflection = 1.183082e-3;  // m, under 100 kN
constexpr double critical_speed = 770.257;         // m/s

// Largest deflection (m, averaged over `hold` s) around a force that moves at `speed` m/s and grows
// smoothly from zero over `rise` s, so that transients are negligible even without damping.
double steady(const LineParameters& parameters, double speed, double rise, double hold) {
  const Line line(parameters);
  const double dt = 1e-2 / speed;  // small compared with 1/(beta v)
  Newmark motion(line.system(), dt);
  double sum = 0;
  std::int64_t counted = 0;
  for (std::int64_t i = 1; static_cast<double>(i) * dt <= rise + hold; ++i) {
    const double time = static_cast<double>(i) * dt, x = 20 + speed * time;
    const double s = std::min(1.0, time / rise);
    Vector force = Vector::Zero(motion.displacement.size());
    line.at(x).add(-100e3 * s * s * s * (10 - 15 * s + 6 * s * s), force);
    motion.accept(motion.free_change(force));
    if (time <= rise + hold / 2) continue;
    double largest = 0;
    for (int k = -20; k <= 20; ++k)
      largest = std::max(largest, -line.at(x + 0.02 * k).deflection(motion.displacement));
    sum += largest;
    ++counted;
  }
  return sum / static_cast<double>(counted);
}

// 1/sqrt(1 - (v/v_cr)^2).
TEST(MovingLoad, AmplificationOnAWinklerBed) {
  const verified::Tolerance tolerance{2e-4, "steps of 10 mm and elements of 0.15 m: 1e-4, twice"};
  verified::near("at 100 m/s", "-",
                 steady(winkler(120, BeamTheory::euler), 100, 0.4, 0.2) / static_deflection,
                 1.008536, tolerance);
  verified::near("at 200 m/s", "-",
                 steady(winkler(150, BeamTheory::euler), 200, 0.3, 0.2) / static_deflection,
                 1.035516, tolerance);
}

// c = 2 zeta sqrt(k m).
TEST(MovingLoad, DampedHalfTheCriticalSpeed) {
  LineParameters p = winkler(180, BeamTheory::euler);
  p.track.bed_damping = 2 * 0.05 * std::sqrt(50e6 * 60.21);
  verified::near("at 0.5 v_cr, zeta 0.05", "-",
                 steady(p, critical_speed / 2, 0.15, 0.15) / static_deflection, 1.15358,
                 {3e-4, "steps of 10 mm and elements of 0.15 m: 1e-4, three times"});
}

// One axle of constant force.
TrainParameters one_axle(double speed) {
  TrainParameters train;
  train.vehicles = {"axle"};
  train.speed = speed;
  train.start = 0;
  return train;
}

std::vector<VehicleParameters> axle(double force) {
  VehicleParameters v;
  v.name = "axle";
  v.kind = VehicleKind::forces;
  v.length = 1;
  v.axles = {0};
  v.loads = {force};
  return {v};
}

TEST(MovingLoad, SingleSpan) {
  const Line line(span(210e9, 1e-4, 0.01 * 7850));
  const TrainParameters motion = one_axle(10);
  const Train train(motion, axle(1e3), 1);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 25), motion,
                  {.step = 5e-4, .duration = 2.5});
  double largest = 0, when = 0, early = 0, late = 0;
  while (passage.time() < 2.5 - 1e-9) {
    passage.advance();
    const double down = -passage.rail_displacement(12.5);
    if (down > largest) largest = down, when = passage.time();
    if (std::abs(passage.time() - 0.5) < 1e-9) early = down;
    if (std::abs(passage.time() - 2.0) < 1e-9) late = down;
  }
  // Elements of 0.625 m: (pi / 40)^4 / 1440 = 3e-8.
  const verified::Tolerance step{
      1e-6, "(omega dt)^2 / 12 = 1.4e-6 of a phase of 11 rad, of 18 mm: 3e-7 m, three times"};
  verified::near("mid-span at 0.5 s", "m", early, 10.96037e-3, step);
  verified::near("mid-span at 2.0 s", "m", late, 10.44064e-3, step);
  verified::near("largest at mid-span", "m", largest, 18.15945e-3, step);
  verified::near("time of the largest", "s", when, 1.32675, {5e-4, "a step"});
}

// Over its own static value 2 P L^3/(pi^4 E I); v_cr = (pi/L) sqrt(E I/m). While the force is on
// the span the largest is sin(2 pi a/(1 + a))/(1 - a), a = v/v_cr, which is largest at a = 0.617.
TEST(MovingLoad, LargestDynamicFactorOfASpan) {
  constexpr double stiffness = 210e9 * 1e-4, mass = 0.01 * 7850, length = 25;  // N m^2, kg/m, m
  const Line line(span(210e9, 1e-4, mass));
  const double critical = std::numbers::pi / length * std::sqrt(stiffness / mass);
  const double at_rest = 2e3 * std::pow(length, 3) / (std::pow(std::numbers::pi, 4) * stiffness);
  const auto factor = [&](double ratio) {
    const TrainParameters motion = one_axle(ratio * critical);
    const Train train(motion, axle(1e3), 1);
    Passage passage(line, train, WheelRail({}), Irregularity({}, length), motion, {.step = 2e-4});
    double largest = 0;
    while (passage.time() < passage.duration()) {
      passage.advance();
      largest =
          std::max(largest, -first_mode(line, 40, passage.line_motion().displacement) / at_rest);
    }
    return largest;
  };
  // Steps of 0.2 ms: (w dt)^2/12 of a mode of 1.3 Hz is 2e-7.
  const double at_best = factor(0.617);
  verified::near("first mode at v/v_cr = 0.617", "-", at_best, 1.7685,
                 {6e-5, "five digits of the reference"});
  const verified::Limit less{1, "the factor is largest at 0.617"};
  verified::below("at 0.57 over that", "-", factor(0.57) / at_best, less);
  verified::below("at 0.67 over that", "-", factor(0.67) / at_best, less);
}

// EN 1991-2: on a span of 10 m with the axles in the middle.
TEST(LoadModel71, MomentOfASpan) {
  LineParameters p = span(210e9, 1e-2, 1000);
  p.track.length = 10;
  const Line line(p);
  TrainParameters motion = one_axle(1);
  motion.vehicles = {"load_model_71"};
  const Train train(motion, {}, 1);
  Vector load = Vector::Zero(line.system().mass.rows());
  // The middle of the pattern in the middle of the span.
  for (const Train::Wheel& wheel : train.wheels())
    if (const double x = 5 + train.axle_distance() / 2 - wheel.behind; x > 0 && x < 10)
      line.at(x).add(-wheel.force, load);
  const Vector u = Statics(line.system()).flexibility(load);
  // No load is in the elements beside the middle (0.625 m), so that the moment there is exact.
  verified::near("moment at mid-span", "N m", line.bending_moment(5, u), 1829.60e3,
                 {0.1, "statically determinate, exact: rounding times the condition, 1e8"});
}

}  // namespace
}  // namespace trackbed::track::moving_load_test
