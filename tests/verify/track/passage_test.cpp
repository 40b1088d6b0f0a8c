// Train and track together: static equilibrium, order in time, loss and recovery of contact.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::passage_test {
namespace {

// A train without speed remains in static equilibrium.
TEST(Passage, StaticEquilibriumIsKept) {
  LineParameters p;
  p.ballast.mass = 500;
  const Line line(p);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 1e-12, .start = 40};
  const Train train(motion, {}, 2);
  IrregularityParameters rough;
  rough.kind = IrregularityKind::spectrum;
  Passage passage(line, train, WheelRail({}), Irregularity(rough, 60), motion, {.duration = 1});
  const Vector rail = passage.line_motion().displacement,
               body = passage.train_motion().displacement;
  const double force = passage.wheel_force(0);
  while (passage.time() < 1) passage.advance();
  verified::below("change of a wheel force in 1 s", "N", std::abs(passage.wheel_force(0) - force),
                  {1e-3, "contacts converge to 1e-12 m: 1 mN"});
  const verified::Limit converged{1e-12, "contacts converge to 1e-12 m"};
  verified::below("largest motion of the track", "m",
                  (passage.line_motion().displacement - rail).cwiseAbs().maxCoeff(), converged);
  verified::below("largest motion of the train", "m",
                  (passage.train_motion().displacement - body).cwiseAbs().maxCoeff(), converged);
}

// For a wheel midway between two nodes, with local deflection.
TEST(Passage, TrackStoresHalfTheWorkOfAStaticWheel) {
  const Line line((LineParameters()));
  const TrainParameters motion{.vehicles = {"wheel"}, .speed = 1e-12, .start = 30.075};
  const VehicleParameters wheel{
      .name = "wheel", .kind = VehicleKind::wheel, .length = 1, .wheelset_mass = 10e3};
  const Train train(motion, {wheel}, 2);
  const WheelRail law((WheelRailParameters()));
  const Passage passage(line, train, law, Irregularity({}, 60), motion, {.duration = 1});
  const double force = passage.wheel_force(0);
  const double surface = passage.wheel_height(0) + law.approach(force);
  const double work = -force * surface / 2;
  verified::near("energy of the track over half the work", "-", passage.track_energy() / work, 1,
                 {1e-9, "the contact converges to 1e-12 m, the rail deflects by 1 mm"});
}

// Also for constant forces between nodes: the energy does not depend on the positions of nodes.
TEST(Passage, TrackEnergyIsTheSameWithFinerElements) {
  const auto energy = [](std::int64_t elements) {
    LineParameters parameters;
    parameters.track.elements = elements;
    const Line line(parameters);
    const TrainParameters motion{.vehicles = {"force"}, .speed = 1e-12, .start = 30.075};
    const VehicleParameters force{
        .name = "force", .kind = VehicleKind::forces, .length = 1, .axles = {0.5}, .loads = {2e5}};
    const Train train(motion, {force}, 2);
    const WheelRail law((WheelRailParameters()));
    const Passage passage(line, train, law, Irregularity({}, 60), motion, {.duration = 1});
    return passage.track_energy();
  };
  EXPECT_NEAR(energy(1) / energy(8), 1, 1e-7);
}

// Newmark's period error at dt/T = 0.1, (2 pi/(w dt) of the discrete oscillator)/T - 1; no damping.
TEST(Newmark, PeriodAndEnergyOfAnOscillator) {
  const double w = 2 * std::numbers::pi;  // rad/s: a period of 1 s
  Sparse one(1, 1);
  one.insert(0, 0) = 1;
  const LinearSystem system{one, 0 * one, w * w * one};
  Newmark motion(system, 0.1);
  motion.displacement[0] = 1;
  motion.acceleration[0] = -w * w;
  const double energy = motion.energy();
  double before = 1, crossing = 0;
  int crossings = 0;
  for (int i = 1; i <= 1000; ++i) {
    motion.accept(motion.free_change(Vector::Zero(1)));
    const double now = motion.displacement[0];
    if (before < 0 && now >= 0) {
      const double time = 0.1 * (i - now / (now - before));
      if (crossings++ == 0)
        crossing = time;
      else if (crossings == 91)
        crossing = (time - crossing) / 90;
    }
    before = now;
  }
  verified::near(
      "period error at dt/T = 0.1", "-", crossing - 1, 0.03207,
      {2e-5, "crossings interpolated to 1 ms in 90 periods, and digits of the reference"});
  verified::near("energy after 1000 steps over that before", "-", motion.energy() / energy, 1,
                 {1e-12, "exact: rounding of 1000 steps, 1e-13, ten times"});
}

// A coach over a smooth dip on a uniform bed: all functions are smooth, so that the error is that
// of the step. Forces of the first wheel every 0.4 ms, N.
std::vector<double> forces_with(double dt) {
  LineParameters p = winkler(60, BeamTheory::euler, 6);
  p.track.bed_damping = 50e3;
  p.track.run_in = 6;
  const Line line(p);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 34};
  const Train train(motion, {}, 2);
  IrregularityParameters dip;
  dip.kind = IrregularityKind::versine;
  dip.at = 37;
  dip.length = 5;
  Passage passage(line, train, WheelRail({}), Irregularity(dip, 60), motion,
                  {.step = dt, .duration = 0.1});
  const auto every = std::lround(4e-4 / dt);
  std::vector<double> forces;
  for (int i = 1; i <= std::lround(0.1 / dt); ++i) {
    passage.advance();
    if (i % every == 0) forces.push_back(passage.wheel_force(0));
  }
  return forces;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(Passage, IsOfSecondOrderInTheStep) {
  const auto a = forces_with(2e-4), b = forces_with(1e-4), c = forces_with(5e-5),
             d = forces_with(2.5e-5);
  const verified::Tolerance order{
      0.2, "second order; wheel on rail, 500 Hz: next term (omega dt)^2 / 4 = 0.1 at the coarsest"};
  verified::near("order from steps of 0.2, 0.1, 0.05 ms", "-",
                 std::log2(distance(a, b) / distance(b, c)), 2, order);
  verified::near("order from steps of 0.1, 0.05, 0.025 ms", "-",
                 std::log2(distance(b, c) / distance(c, d)), 2, order);
  verified::below("root mean square change of the wheel force from 0.1 to 0.05 ms", "N",
                  distance(b, c), {20, "guards the factor beside the order: 6 N, three times"});
}

// On an even rail wheels are excited by the sleepers only. At the ends, at the transition to rigid
// rails, the excitation is less than twice that in the middle.
TEST(Passage, WheelsEnterAndLeaveWithoutAnImpact) {
  const Line line((LineParameters()));
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = -1};
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 60), motion, {});
  const double at_rest = passage.wheel_force(0);
  double inside = 0, ends = 0;
  while (passage.time() < passage.duration()) {
    passage.advance();
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = passage.wheel_x(i), off = std::abs(passage.wheel_force(i) / at_rest - 1);
      if (x > 12 && x < 48) inside = std::max(inside, off);
      if (x < 6 || x > 54) ends = std::max(ends, off);
    }
  }
  verified::below("largest change of a wheel force over the sleepers", "-", inside,
                  {0.05, "the rail is stiffer on a sleeper than in mid-bay, by a few percent"});
  verified::below("within 6 m of the ends over that in the middle", "-", ends / inside,
                  {2, "separates from an impact"});
}

// A slowly rolling wheel is lowered by the depth of its flat, l^2/(16 R), once in each turn.
TEST(WheelFlat, ASlowWheelFollowsIt) {
  const Line line(winkler(60, BeamTheory::timoshenko));
  const TrainParameters motion{.vehicles = {"wheel"}, .speed = 0.1, .start = 28.3};
  VehicleParameters wheel;
  wheel.name = "wheel";
  wheel.kind = VehicleKind::wheel;
  wheel.length = 2;
  wheel.wheelset_mass = 1800;
  const Train train(motion, {wheel}, 2);
  WheelRailParameters flat;
  flat.flat_axle = 1;
  flat.flat_length = 0.05;
  flat.flat_at = 28.5;
  Passage passage(line, train, WheelRail(flat), Irregularity({}, 60), motion, {.step = 4e-3});
  const double before = passage.wheel_height(0), turn = 2 * std::numbers::pi * 0.46;
  double lowest = 0, where = 0, lowest_again = 0, again = 0;  // m, of the height and of x
  while (passage.wheel_x(0) < 28.5 + turn + 0.2) {
    passage.advance();
    const double down = before - passage.wheel_height(0), x = passage.wheel_x(0);
    if (x < 29.5 && down > lowest) lowest = down, where = x;
    if (x > 30 && down > lowest_again) lowest_again = down, again = x;
  }
  const double depth = 0.05 * 0.05 / (16 * 0.46);
  // The wheel is lowered by 0.34 mm within 0.25 s: its inertia force is 0.3 % of its weight, under
  // which rail and contact deflect by 0.1 mm.
  const verified::Tolerance inertia{4e-3, "inertia: 0.3 % of a deflection of 0.1 mm, four times"};
  verified::near("depth", "m", lowest, depth, inertia.of(depth));
  verified::near("once more after a turn", "m", lowest_again, depth, inertia.of(depth));
  verified::near("distance between", "m", again - where, turn, {8e-4, "a step of 0.4 mm at both"});
}

// A wheel loses contact over a deep short dip, recovers it, and returns to its static load.
TEST(Passage, ContactIsLostAndRecovered) {
  LineParameters damped = winkler(60, BeamTheory::timoshenko);
  damped.track.bed_damping = 100e3;
  const Line line(damped);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 30};
  const Train train(motion, {}, 2);
  IrregularityParameters dip;
  dip.kind = IrregularityKind::joint;
  dip.at = 32;
  dip.length = 1;
  dip.depth = 4e-3;
  Passage passage(line, train, WheelRail({}), Irregularity(dip, 60), motion,
                  {.step = 1e-4, .duration = 0.3});
  const double at_rest = passage.wheel_force(0);
  double least = at_rest, most = at_rest;
  while (passage.time() < 0.3) {
    passage.advance();
    least = std::min(least, passage.wheel_force(0));
    most = std::max(most, passage.wheel_force(0));
  }
  verified::near("least force of the first wheel", "N", least, 0, {1e-9, "no contact: exactly 0"});
  verified::above("largest over static force", "-", most / at_rest, {2, "separates: an impact"});
  verified::above("steps times wheels without contact", "-", static_cast<double>(passage.lost()),
                  {10, "separates: the contact is lost"});
  verified::near("force 13 m behind the dip over static", "-", passage.wheel_force(0) / at_rest, 1,
                 {0.1, "separates: what remains is the bogie's vibration, a few percent"});
}

}  // namespace
}  // namespace trackbed::track::passage_test
