// Two rails: symmetric motion must equal the plane track, antisymmetric motion a plane track with
// other masses and springs, and roll must agree with closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "trackbed/core/types.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::space_test {
namespace {

LineParameters track(Dimension dimension) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 36;
  p.ballast.mass = 300;
  return p;
}

struct Scene {
  Scene(const LineParameters& p, const std::vector<VehicleParameters>& own, TrainParameters of,
        const Irregularity& left, const std::optional<Irregularity>& right,
        PassageParameters parameters)
      : motion(of),
        line(p),
        train(motion, own, p.track.rails, p.track.wheel_gauge()),
        passage(line, train, WheelRail({}), left, motion, parameters, right) {}
  TrainParameters motion;
  Line line;
  Train train;
  Passage passage;
};

// All features together: an irregular rail, hanging sleepers, bilinear pads.
TEST(TwoRails, UnderASymmetricLoadAreThePlaneTrack) {
  IrregularityParameters rough;
  rough.kind = IrregularityKind::spectrum;
  const auto made = [&](Dimension dimension) {
    LineParameters p = track(dimension);
    p.pad.bilinear_at = 2e-4, p.pad.bilinear_stiffness = 300e6;
    p.track.zones = {{.from = 17.9, .to = 19.3, .gap = 2e-4}};
    return Scene(p, {}, {.vehicles = {"manchester_1"}, .speed = 50, .start = 10},
                 Irregularity(rough, 36), {}, {});
  };
  Scene plane = made(Dimension::plane), space = made(Dimension::space);
  double force = 0, rail = 0, roll = 0;
  for (int i = 0; i < 1500; ++i) {
    plane.passage.advance(), space.passage.advance();
    for (std::size_t axle = 0; axle < 4; ++axle)
      for (std::size_t side = 0; side < 2; ++side)
        force = std::max(force, std::abs(space.passage.wheel_force(2 * axle + side) -
                                         plane.passage.wheel_force(axle)));
    for (std::size_t side = 0; side < 2; ++side)
      rail = std::max(rail, std::abs(space.passage.rail_displacement(18.6, side) -
                                     plane.passage.rail_displacement(18.6)));
    for (const std::int32_t unknown : space.train.roll_unknown())
      roll = std::max(roll, std::abs(space.passage.train_motion().displacement[unknown]));
  }
  const verified::Limit converged{4e-12, "contacts converge to 1e-12 m, four times"};
  verified::below("largest difference of a wheel force", "N", force,
                  {5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"});
  verified::below("largest difference of the rail", "m", rail, converged);
  verified::below("largest roll of the body", "rad", roll, converged);
}

// u on the left, -u on the right: each rail is the plane track with
//   sleeper mass 4 I/g^2 (of a whole one), ballast k L^2/(3 g^2), likewise its damping,
// g the gauge, L the sleeper's length. The ballast mass below each end moves with
// (1/2 + y/g) - (1/2 - y/g) = 2 y/g of u, y = L/sqrt(12); without it the reduction is exact.
TEST(TwoRails, UnderAnAntisymmetricLoadAreAPlaneTrackWithOtherValues) {
  LineParameters both = track(Dimension::space), one = track(Dimension::plane);
  both.ballast.mass = one.ballast.mass = 0;
  const double gauge = both.track.gauge, length = both.track.sleeper_length;
  const double roll = both.track.sleeper_mass * length * length / 12;
  const double softer = length * length / (3 * gauge * gauge);
  one.track.sleeper_mass = 4 * roll / (gauge * gauge);
  one.ballast.stiffness *= softer, one.ballast.damping *= softer;
  RailForce left;
  left.kind = ForceKind::impact;
  left.at = 18, left.size = 20e3, left.length = 4e-3;
  RailForce right = left;
  right.side = ForceSide::right, right.size = -left.size;
  const TrainParameters none{.vehicles = {}, .speed = 1, .start = 0};
  Scene space(both, {}, none, Irregularity({}, 36), {}, {.duration = 0.1, .forces = {left, right}});
  Scene plane(one, {}, none, Irregularity({}, 36), {}, {.duration = 0.1, .forces = {left}});
  Scene single(both, {}, none, Irregularity({}, 36), {}, {.duration = 0.1, .forces = {left}});
  LineParameters level = track(Dimension::plane);
  level.ballast.mass = 0;
  Scene even(level, {}, none, Irregularity({}, 36), {}, {.duration = 0.1, .forces = {left}});
  double difference = 0, mirrored = 0, halves = 0, most = 0;
  for (int i = 0; i < 500; ++i) {
    for (Scene* run : {&space, &plane, &single, &even}) run->passage.advance();
    const double u = plane.passage.rail_displacement(18), s = even.passage.rail_displacement(18);
    difference = std::max(difference, std::abs(space.passage.rail_displacement(18, 0) - u));
    mirrored = std::max(mirrored, std::abs(space.passage.rail_displacement(18, 1) + u));
    halves = std::max(halves, std::abs(single.passage.rail_displacement(18, 1) - (s - u) / 2));
    most = std::max(most, std::abs(u));
  }
  const verified::Limit rounding{
      1e-15, "linear: rounding of 0.2 mm in 500 steps, 1e-17 m, times a condition of 100"};
  verified::above("largest of the rail", "m", most, {1e-5, "separates: the rail moves"});
  verified::below("left rail, difference", "m", difference, rounding);
  verified::below("right rail, difference", "m", mirrored, rounding);
  verified::below("right rail under an impact on the left one, against half the difference of both",
                  "m", halves, rounding);
}

// Body and bogies in phase: I_b, I_g, springs k_s of each bogie's secondary and k_p of its
// primaries against roll, N m/rad:
//   (2 k_s - I_b w^2)(k_s + k_p - I_g w^2) = 2 k_s^2;   bogies against each other: w^2 I_g = k_s +
//   k_p.
TEST(Roll, FrequenciesOfTheManchesterVehicle) {
  constexpr double body = 56800, bogie = 1722;                // kg m^2
  constexpr double secondary = 0.86e6, primary = 2 * 2.44e6;  // at 1 m from the middle
  constexpr double a = body * bogie;
  constexpr double b = body * (secondary + primary) + 2 * secondary * bogie;
  constexpr double c = 2 * secondary * (secondary + primary) - 2 * secondary * secondary;
  const double root = std::sqrt(b * b - 4 * a * c);
  const auto hertz = [](double square) { return std::sqrt(square) / (2 * std::numbers::pi); };
  const std::vector<double> expected = {hertz((b - root) / (2 * a)),
                                        hertz((secondary + primary) / bogie),
                                        hertz((b + root) / (2 * a))};
  const VehicleParameters& vehicle = vehicle_library().front();
  ASSERT_EQ(vehicle.name, "manchester_1");
  const std::vector<double> all = natural_frequencies(vehicle, true);
  ASSERT_EQ(all.size(), 9U);
  for (const double reference : expected) {
    double nearest = 0;
    for (const double found : all)
      if (std::abs(found - reference) < std::abs(nearest - reference)) nearest = found;
    verified::near(
        fmt::format("roll at {:.3f} Hz", reference), "Hz", nearest, reference,
        {1e-11, "rounding of 9 Hz, 1e-15, times the ratio of eigenvalues, 250, forty times"});
  }
}

// A body whose centre of mass is e to the left: moment m g e, distributed over four axles, which
// rolls the body on its springs. Static on a rigid rail before the track, and on the track.
TEST(Roll, MomentOfAShiftedLoadReachesTheWheels) {
  VehicleParameters v;
  v.name = "shifted", v.like = "manchester_1", v.body_offset = 0.1;
  const double moment = 32000 * gravity * 0.1;
  for (const auto& [start, where] : {std::pair{-1.0, "on rigid rails"}, {30.0, "on the track"}}) {
    const LineParameters p = track(Dimension::space);
    const Scene run(p, {v}, {.vehicles = {"shifted"}, .speed = 1e-9, .start = start},
                    Irregularity({}, 36), {}, {.duration = 1});
    double sum = 0, all = 0;
    for (std::size_t axle = 0; axle < 4; ++axle) {
      const double left = run.passage.wheel_force(2 * axle),
                   right = run.passage.wheel_force(2 * axle + 1);
      sum += (left - right) * p.track.gauge / 2;
      all += left + right;
    }
    const verified::Tolerance contacts{1e-6, "contacts converge to 1e-12 m: 1.3 mN each"};
    verified::near(fmt::format("moment of the wheels about the middle, {}", where), "N m", sum,
                   moment, contacts.of(moment));
    verified::near(fmt::format("sum of the wheels, {}", where), "N", all, 4 * 109092,
                   {2, "the load of an axle is given to 0.5 N"});
    if (start > 0) continue;
    const double each = run.passage.wheel_force(0) - run.passage.wheel_force(1);
    verified::near("difference of the wheels of an axle", "N", each, moment / (2 * p.track.gauge),
                   contacts.of(each));
    // Unknowns: body z, pitch, roll; bogie z, pitch, roll.
    const Vector& u = run.passage.train_motion().displacement;
    verified::near("roll of the body against a bogie", "rad", u[5] - u[2], moment / 2 / 0.86e6,
                   {1e-9, "contacts converge to 1.3 mN, on levers of 0.75 m and 0.86 MN m"});
  }
}

// A dip of one rail only excites roll of wheelsets, bogies and body.
std::vector<double> roll_with(double step) {
  IrregularityParameters dip;
  dip.kind = IrregularityKind::versine;
  dip.at = 22, dip.length = 5;
  LineParameters p = track(Dimension::space);
  p.track.support = Support::continuous;
  p.track.bed_damping = 50e3;
  p.rail.theory = BeamTheory::euler;
  Scene run(p, {}, {.vehicles = {"manchester_1"}, .speed = 50, .start = 19}, Irregularity(dip, 36),
            Irregularity({}, 36), {.step = step, .duration = 0.1});
  const auto every = std::lround(4e-4 / step);
  std::vector<double> found;
  for (int i = 1; i <= std::lround(0.1 / step); ++i) {
    run.passage.advance();
    if (i % every == 0) found.push_back(run.passage.wheel_force(0) - run.passage.wheel_force(1));
  }
  return found;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(Roll, IsOfSecondOrderInTheStep) {
  const auto a = roll_with(2e-4), b = roll_with(1e-4), c = roll_with(5e-5), d = roll_with(2.5e-5);
  verified::above("largest difference of left and right wheel", "N",
                  *std::max_element(a.begin(), a.end()), {1e3, "separates: the axles roll"});
  const verified::Tolerance order{
      0.2, "second order; wheel on rail, 500 Hz: next term (omega dt)^2 / 4 = 0.1 at the coarsest"};
  verified::near("order from steps of 0.2, 0.1, 0.05 ms", "-",
                 std::log2(distance(a, b) / distance(b, c)), 2, order);
  verified::near("order from steps of 0.1, 0.05, 0.025 ms", "-",
                 std::log2(distance(b, c) / distance(c, d)), 2, order);
}

}  // namespace
}  // namespace trackbed::track::space_test
