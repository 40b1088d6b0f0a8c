// Nonlinear supports: hanging sleepers with a gap to the ballast, bilinear pads.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::stops_test {
namespace {

constexpr double wheel = 60e3;  // N
constexpr double place = 12;    // m, below a sleeper

// The track without ballast has 1e-9 of it left, at a deflection of 1 mm.
const verified::Tolerance remaining{
    1e-11, "ballast of 1e-9 of its stiffness below 1 mm: 6e-5 N, which is 1e-12 m, ten times"};

std::vector<VehicleParameters> axle() {
  VehicleParameters v;
  v.name = "axle";
  v.kind = VehicleKind::forces;
  v.length = 1;
  v.axles = {0};
  v.loads = {2 * wheel};
  return {v};
}

// Static equilibrium under one constant force above the sleeper at 12 m.
struct AtRest {
  explicit AtRest(const LineParameters& p)
      : line(p),
        train(motion, axle(), 2),
        passage(line, train, WheelRail({}), Irregularity({}, 24), motion, {.duration = 1}) {}
  double rail(double x = place) const { return -passage.rail_displacement(x); }
  double seat(double x = place) const {
    const Newmark& u = passage.line_motion();
    return line.seat_force(line.nearest_sleeper(x), u.displacement, u.velocity);
  }
  TrainParameters motion{.vehicles = {"axle"}, .speed = 1e-12, .start = place};
  Line line;
  Train train;
  Passage passage;
};

LineParameters sleepers(double gap) {
  LineParameters p;
  p.track.length = 24;
  p.track.zones = {{.from = 11.9, .to = 12.1, .gap = gap}};
  return p;
}

// A gap larger than the deflection of the rail is equivalent to no ballast, a gap of 0 is the
// linear track. In between the rail's displacement is linear in the ballast force f = k (w_s -
// gap): two linear tracks give the reference.
TEST(HangingSleeper, IsBetweenTwoLinearTracks) {
  LineParameters none = sleepers(0), all = sleepers(0);
  none.track.zones[0].bed = 1e-9;
  const AtRest without(none), with(all), open(sleepers(0.02)), hanging(sleepers(0.2e-3));
  verified::near("rail over an open gap", "m", open.rail(), without.rail(), remaining);
  // Static: the seat force equals the ballast force.
  verified::near("seat over an open gap", "N", open.seat(), 0,
                 {2e-10, "rounding of 1 mm, 2e-19 m, times the pad's 120 MN/m, ten times"});
  verified::above("rail over a gap of 0.2 mm, beyond the linear track", "m", hanging.rail(),
                  {with.rail(), "separates: lower than without a gap"});
  // The ballast force lifts rail and sleeper; from no ballast to full ballast it is `with.seat()`,
  // so that influence coefficients follow from both: r = (w_0 - w_1)/f_1.
  const double f1 = with.seat();
  const auto sleeper = [](const AtRest& at) {
    return -at.passage.line_motion()
                .displacement[at.line.sleeper_unknown(at.line.nearest_sleeper(place))];
  };
  const double s0 = sleeper(without), influence = (s0 - sleeper(with)) / f1;
  const double k = all.ballast.stiffness, gap = 0.2e-3;
  const double f = k * (s0 - gap) / (1 + k * influence);
  const verified::Tolerance linear{
      1e-7,
      "ballast of 1e-9, and static equilibrium to 1e-12 m times 60 MN/m: 3e-9 each, many times"};
  verified::near("seat over a gap of 0.2 mm", "N", hanging.seat(), f, linear.of(f));
  verified::near("rail over a gap of 0.2 mm", "m", hanging.rail(),
                 without.rail() - f * (without.rail() - with.rail()) / f1, remaining);
}

// All pads are bilinear; a wheel without speed remains in static equilibrium.
TEST(BilinearPad, FollowsItsTwoStiffnesses) {
  LineParameters p = sleepers(0);
  p.pad.bilinear_at = 1e-4;
  p.pad.bilinear_stiffness = 500e6;
  AtRest at(p);
  const double rail = at.rail(), seat = at.seat();
  const std::int32_t unknown = at.line.sleeper_unknown(at.line.nearest_sleeper(place));
  const double compressed = rail + at.passage.line_motion().displacement[unknown];
  const verified::Tolerance rounding{
      1e-10, "the law of the pad: rounding of 1 mm, 2e-19 m, times 500 MN/m, is 4e-15 of it"};
  const verified::Tolerance equilibrium{
      1e-7, "static equilibrium to 1e-12 m times 500 MN/m: 5e-4 N of 26 kN, five times"};
  verified::above("compression of the pad", "m", compressed,
                  {p.pad.bilinear_at, "separates: the second stiffness acts"});
  verified::near("seat force", "N", seat,
                 p.pad.stiffness * p.pad.bilinear_at +
                     p.pad.bilinear_stiffness * (compressed - p.pad.bilinear_at),
                 rounding.of(seat));
  verified::near("ballast force", "N",
                 -p.ballast.stiffness * at.passage.line_motion().displacement[unknown], seat,
                 equilibrium.of(seat));
  for (int i = 0; i < 200; ++i) at.passage.advance();
  verified::below("motion in 200 steps", "m", std::abs(at.rail() - rail),
                  {1e-12, "static equilibrium to 1e-12 m"});
}

// A coach over hanging sleepers, which strike the ballast.
TEST(HangingSleeper, StrikesTheBallastUnderAPassingCoach) {
  LineParameters p;
  p.track.zones = {{.from = 29.9, .to = 31.3, .gap = 0.5e-3}};  // three sleepers
  const Line line(p);
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 26};
  const Train train(motion, {}, 2);
  LineParameters sound;
  const Line even(sound);
  const auto run = [&](const Line& on) {
    Passage passage(on, train, WheelRail({}), Irregularity({}, 60), motion, {.duration = 0.2});
    double most = 0;
    while (passage.time() < 0.2) {
      passage.advance();
      const Newmark& u = passage.line_motion();
      most = std::max(most, std::abs(u.acceleration[on.sleeper_unknown(on.nearest_sleeper(30.6))]));
    }
    return most;
  };
  verified::above("largest acceleration of the sleeper over that of a sound track", "-",
                  run(line) / run(even), {2, "separates: an impact"});
}

// s of processor time for 40 steps of a vehicle on 120 m, the least of three runs.
double cost(const LineParameters& given) {
  LineParameters p = given;
  p.track.length = 120;
  const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 40};
  const Line line(p);
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 120), motion, {});
  double least = 1e9;
  for (int trial = 0; trial < 3; ++trial) {
    const std::clock_t begin = std::clock();
    for (int i = 0; i < 40; ++i) passage.advance();
    least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return least;
}

// 201 bilinear pads: they are in the equations of the contacts only beyond bilinear_at. With all of
// them in the equations a step took more than ten times as long.
TEST(BilinearPad, CostsLittleWithinTheFirstStiffness) {
  LineParameters linear = sleepers(0), bilinear = sleepers(0);
  bilinear.pad.bilinear_at = 1e-3, bilinear.pad.bilinear_stiffness = 600e6;
  EXPECT_LT(cost(bilinear), 4 * cost(linear));
}

}  // namespace
}  // namespace trackbed::track::stops_test
