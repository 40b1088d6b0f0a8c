// Pads with uplift (pad.uplift): tension is limited to their preload, and the rail lifts off.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "support/verified.hpp"
#include "trackbed/core/decompositions.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::uplift_test {
namespace {

LineParameters lifting(double length, double preload = 0) {
  LineParameters p;
  p.pad.uplift = true;
  p.pad.preload = preload;
  p.track.length = length;
  p.track.run_in = 0;
  return p;
}

// Forces on one rail, N downwards, m behind the first one, which is at `start`.
struct Loaded {
  Loaded(const LineParameters& p, double start, const std::vector<double>& behind,
         std::vector<double> loads)
      : line(p), motion{.vehicles = {"pattern"}, .speed = 1e-12, .start = start} {
    for (double& load : loads) load *= 2;
    VehicleParameters pattern{.name = "pattern", .kind = VehicleKind::forces, .length = 1};
    pattern.axles = behind;
    pattern.loads = loads;
    train.emplace(motion, std::vector{pattern}, 2);
    passage.emplace(line, *train, WheelRail({}), Irregularity({}, p.track.length), motion,
                    PassageParameters{.duration = 1});
  }
  double rail(double x) const { return passage->rail_displacement(x); }
  double seat(std::size_t i) const { return passage->on_sleeper(i); }
  Line line;
  TrainParameters motion;
  std::optional<Train> train;
  std::optional<Passage> passage;
};

// A rail lifted off all pads is supported at its pinned ends only:
//   w = F L^3/(48 E I) + F L/(4 k G A)
TEST(Uplift, ARailLiftedOffAllPadsIsASimpleBeam) {
  constexpr double force = 20e3, length = 2.4;  // N, m
  for (const BeamTheory theory : {BeamTheory::euler, BeamTheory::timoshenko}) {
    LineParameters p = lifting(length);
    p.rail.theory = theory;
    Loaded at(p, length / 2, {0}, {-force});
    const Beam rail = beam_of(p.rail);
    const double shear =
        theory == BeamTheory::euler ? 0 : force * length / (4 * rail.shear_stiffness);
    const double expected = force * std::pow(length, 3) / (48 * rail.bending_stiffness) + shear;
    const verified::Tolerance exact{1e-10,
                                    "exact at nodes: rounding times the condition, 1e5, ten times"};
    verified::near(theory == BeamTheory::euler ? "Euler, middle" : "Timoshenko, middle", "m",
                   at.rail(length / 2), expected, exact.of(expected));
    for (std::size_t i = 0; i < at.line.sleepers(); ++i) EXPECT_EQ(at.seat(i), 0) << i;
    for (int i = 0; i < 100; ++i) at.passage->advance();
    verified::near(
        theory == BeamTheory::euler ? "Euler, after 100 steps" : "Timoshenko, after 100 steps", "m",
        at.rail(length / 2), expected, exact.of(expected));
  }
}

// Row of the pad's compression: height of the sleeper's end minus that of the rail.
Vector pad_row(const Line& line, std::size_t i, std::size_t side) {
  Vector row = Vector::Zero(line.system().mass.rows());
  row[line.sleeper_unknown(i, side)] = 1;
  line.at(line.sleeper_x(i), side).add(-1, row);
  return row;
}

// An upward force between two wheels. Reference: a direct solution of the linear track without the
// open pads; the remaining pads must be compressed, the removed ones open.
void check_uplift(const LineParameters& p, const std::string& where) {
  const Line line(p);
  const TrainParameters motion{.vehicles = {"pattern"}, .speed = 1e-12, .start = 15};
  VehicleParameters pattern{.name = "pattern", .kind = VehicleKind::forces, .length = 1};
  pattern.axles = {0, 3, 6};
  pattern.loads = {120e3, -60e3, 120e3};
  const Train train(motion, {pattern}, 2, p.track.wheel_gauge());
  const Passage passage(line, train, WheelRail({}), Irregularity({}, 24), motion, {});
  Eigen::MatrixXd stiffness = line.system().stiffness;
  Vector load = Vector::Zero(stiffness.rows());
  for (std::size_t side = 0; side < line.sides(); ++side)
    for (const auto& [x, force] : {std::pair{15.0, 60e3}, {12.0, -30e3}, {9.0, 60e3}})
      line.at(x, side).add(-force, load);
  const Vector& u = passage.line_motion().displacement;
  const double preload = p.pad.preload, unloaded = -preload / p.pad.stiffness;
  std::int64_t open = 0;
  double least = 1, widest = -1;
  // The ends are pinned: the first and the last sleeper are unloaded.
  for (std::size_t i = 1; i + 1 < line.sleepers(); ++i)
    for (std::size_t side = 0; side < line.sides(); ++side) {
      const Vector row = pad_row(line, i, side);
      const double seat = passage.on_sleeper(i, side);
      EXPECT_GE(seat, -preload * (1 + 1e-12));
      if (seat > -preload * (1 - 1e-12)) {
        least = std::min(least, row.dot(u) - unloaded);
        continue;
      }
      stiffness -= p.pad.stiffness * row * row.transpose();
      load += preload * row;  // the rail's weight, which the pad no longer carries
      widest = std::max(widest, row.dot(u) - unloaded);
      ++open;
    }
  verified::above(where + ", open pads", "-", static_cast<double>(open),
                  {2.5, "separates: more than two pads are open"});
  verified::above(where + ", least compression of a closed pad", "m", least,
                  {0, "closed: not lifted"});
  verified::below(where + ", largest compression of an open pad", "m", widest, {0, "open: lifted"});
  const Vector expected = solution(stiffness, load);
  verified::below(where + ", largest difference to the track without these pads", "m",
                  (u - expected).cwiseAbs().maxCoeff(), {1e-12, "static equilibrium to 1e-12 m"});
}

TEST(Uplift, BetweenLoadsEqualsTheTrackWithoutOpenPads) {
  LineParameters p = lifting(24);
  check_uplift(p, "one rail");
  p.track.sleeper.model = SleeperModel::beam;
  check_uplift(p, "one rail, bending sleepers");
  p.track.sleeper.model = SleeperModel::rigid;
  p.track.dimension = Dimension::space;
  check_uplift(p, "two rails");
}

TEST(Uplift, OpenPadsHaveLostTheirPreload) {
  LineParameters p = lifting(24, 400);
  check_uplift(p, "one rail, preload");
  p.track.dimension = Dimension::space;
  check_uplift(p, "two rails, preload");
}

// A crossing is three times as heavy; the last pad carries half a bay.
TEST(Uplift, PreloadIsTheWeightOfTheRailOnThePad) {
  LineParameters p = lifting(24, -1);
  p.rail.mass = 60;
  p.track.zones = {{.from = 6, .to = 24, .rail = 3}};
  Loaded at(p, 12, {0}, {-300e3});
  const double bay = 60 * 0.6 * gravity;  // N
  for (const double x : {10.8, 12.0, 13.2})
    verified::near(
        fmt::format("open pad at {:g} m", x), "N", at.seat(at.line.nearest_sleeper(x)), -3 * bay,
        {5e-9, "rounding of 5 mm, 9e-19 m, times the pad's 120 MN/m: 1e-10 N, fifty times"});
  LineParameters short_of = lifting(1.2, -1);
  short_of.rail.mass = 60;
  Loaded all(short_of, 0.6, {0}, {-50e3});
  EXPECT_NEAR(all.seat(1), -bay, 1e-9 * bay);
}

// In the run-in pads and ballast are stiffer, but the preload is the same: an open pad lifts the
// sleeper by it, against an equal tension of the ballast.
TEST(Uplift, PadsInTheRunInHaveTheSamePreload) {
  LineParameters p = lifting(24, 400);
  p.track.run_in = 6, p.track.run_in_factor = 10;
  Loaded at(p, 3.6, {0}, {-10e3});
  const Vector& u = at.passage->line_motion().displacement;
  const verified::Tolerance equilibrium{
      4e-4, "static equilibrium to 1e-12 m times 0.6 GN/m: 6e-4 N at most"};
  for (std::size_t i = 1; i < 10; i += 2) {
    const double x = at.line.sleeper_x(i), height = u[at.line.sleeper_unknown(i)];
    const double stiffer = std::pow(10, (1 + std::cos(std::numbers::pi * x / 6)) / 2);
    EXPECT_GT(at.rail(x) - height, 1.1 * 400 / (p.pad.stiffness * stiffer));
    verified::near(fmt::format("seat force at {:g} m", x), "N", at.seat(i), -400, equilibrium);
    verified::near(fmt::format("tension of the ballast at {:g} m", x), "N",
                   p.ballast.stiffness * stiffer * height, 400, equilibrium);
  }
}

// A rail lifted by a coach returns to its pads under its weight.
TEST(Uplift, TheRailReturnsToItsPadsAfterTheTrain) {
  LineParameters p = lifting(30, -1);
  const Line line(p);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 0};
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 30), motion, {.duration = 2.5});
  double highest = 0, left = 0;
  while (passage.time() < 2.5) {
    passage.advance();
    for (double x = 1.2; x < 29; x += 0.6) {
      const double height = passage.rail_displacement(x);
      highest = std::max(highest, height);
      if (passage.time() > 2.4) left = std::max(left, std::abs(height));
    }
  }
  verified::above("highest while the coach passes", "m", highest,
                  {1e-5, "separates: it is lifted"});
  verified::below("largest displacement 1 s after", "m", left,
                  {1e-6, "separates: it is back on its pads"});
}

// Least seat force of all sleepers while a coach passes, N; with dampers.
double least_seat(bool uplift) {
  LineParameters p;
  p.pad.uplift = uplift;
  p.pad.preload = 0;
  const Line line(p);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 26};
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 60), motion, {});
  double least = 0;
  while (passage.time() < 0.15) {
    passage.advance();
    for (std::size_t i = 0; i < line.sleepers(); ++i)
      least = std::min(least, passage.on_sleeper(i));
  }
  return least;
}

TEST(Uplift, NoTensionInPadsWhileACoachPasses) {
  verified::below("least seat force without uplift", "N", least_seat(false),
                  {-500, "separates: pads would be in tension"});
  verified::near("least seat force with uplift", "N", least_seat(true), 0,
                 {1e-9, "open pads: exactly 0"});
}

// J, of the matrices' springs without the fictitious energy of open pads.
double energy_of(const Passage& passage, const PadParameters& pad) {
  const Line& line = passage.line();
  double energy = passage.line_motion().energy();
  for (std::size_t i = 0; i < line.sleepers(); ++i) {
    const double compression = pad_row(line, i, 0).dot(passage.line_motion().displacement);
    const double left = compression + pad.preload / pad.stiffness;
    energy -= pad.stiffness * std::pow(std::min(0.0, left), 2) / 2;
  }
  return energy;
}

// After an upward impact, without dampers: largest change of the energy over the energy.
double drift(double step, double preload) {
  LineParameters p = lifting(6, preload);
  p.pad.damping = p.ballast.damping = 0;
  const Line line(p);
  TrainParameters motion;
  motion.vehicles.clear();
  const Train train(motion, {}, 2);
  PassageParameters run{.step = step, .duration = 0.1};
  run.forces = {{.kind = ForceKind::impact, .at = 3, .size = -100e3, .length = 4e-3}};
  Passage passage(line, train, WheelRail({}), Irregularity({}, 6), motion, run);
  double after = 0, furthest = 0;
  while (passage.time() < 0.05) {
    passage.advance();
    if (passage.time() < 4.5e-3) continue;
    const double energy = energy_of(passage, p.pad);
    if (after == 0) after = energy;
    furthest = std::max(furthest, std::abs(energy - after));
  }
  return furthest / after;
}

TEST(Uplift, EnergyIsKeptWithoutDampers) {
  for (const double preload : {0.0, 400.0}) {  // N
    const std::string with = fmt::format(", preload {:g} N", preload);
    const double coarse = drift(2e-5, preload), middle = drift(1e-5, preload),
                 fine = drift(5e-6, preload);
    verified::below(
        "largest change of energy, steps of 20 us" + with, "-", coarse,
        {3e-4, "pads open within a step: k (v dt)^2 / 8 each, 1e-5 of the energy, 30 times"});
    verified::near(
        "the same over that with steps of 5 us (second order: 16)" + with, "-", coarse / fine, 16,
        {8, "second order; openings at any place of a step change the sum by up to half"});
    verified::near(
        "the same over that with steps of 10 us (second order: 4)" + with, "-", coarse / middle, 4,
        {2.5, "second order; openings at any place of a step change the sum by up to half"});
  }
}

}  // namespace
}  // namespace trackbed::track::uplift_test
