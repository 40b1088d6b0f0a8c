// Vehicles: natural frequencies, static loads, and a sprung mass that crosses a bridge.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::vehicle_test {
namespace {

const VehicleParameters& of_library(const std::string& name) {
  for (const VehicleParameters& v : vehicle_library())
    if (v.name == name) return v;
  throw std::runtime_error(name);
}

TEST(Vehicle, FrequenciesOfTheManchesterVehicle) {
  const std::vector<double> expected = {1.0739, 1.2991, 7.4705, 7.4772, 11.7138, 11.7138};
  const std::vector<double> found = natural_frequencies(of_library("manchester_1"));
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    verified::near(fmt::format("mode {}", i + 1), "Hz", found[i], expected[i],
                   {6e-5, "four decimals of the reference"});
}

// Bounce of the carried mass m over the bogie's t, and pitch of the bogie alone:
//   m t w^4 - (m (k_s + 2 k_p) + t k_s) w^2 + 2 k_s k_p = 0,   w^2 = k_p a^2/(2 I)
// k_s, k_p of secondary and of one wheelset's springs, a the wheelbase, I the pitch inertia.
TEST(Vehicle, FrequenciesOfABogieAlone) {
  const VehicleParameters& v = of_library("x2_bogie");
  const double ks = v.secondary_stiffness, kp = v.primary_stiffness;
  const double m = v.body_mass, t = v.bogie_mass;
  const double half = (m * (ks + 2 * kp) + t * ks) / (2 * m * t);
  const double root = std::sqrt(half * half - 2 * ks * kp / (m * t));
  const double turn = kp * v.wheelbase * v.wheelbase / (2 * v.bogie_inertia);
  const std::vector<double> found = natural_frequencies(v);
  ASSERT_EQ(found.size(), 3U);
  const auto hertz = [](double square) { return std::sqrt(square) / (2 * std::numbers::pi); };
  const verified::Tolerance rounding{
      1e-11, "rounding of 13 Hz, 2e-15, times the ratio of eigenvalues, 250, twenty times"};
  verified::near("bounce of what it carries", "Hz", found[0], hertz(half - root), rounding);
  verified::near("bounce of the bogie", "Hz", found[1], hertz(half + root), rounding);
  verified::near("pitch of the bogie", "Hz", found[2], hertz(turn), rounding);
}

// A coach of two such bogies without pitch of its body moves like two of them: bounce, pitch and
// roll of the bogie are among the coach's modes.
TEST(Vehicle, ABogieAloneIsHalfOfASymmetricCoach) {
  const VehicleParameters bogie = complete(of_library("x2_bogie"));
  VehicleParameters coach = bogie;
  coach.kind = VehicleKind::coach;
  coach.length = 26;
  coach.body_mass *= 2;
  coach.body_roll *= 2;
  coach.bogie_distance = 19;
  const std::vector<double> all = natural_frequencies(coach, true);
  const std::vector<double> found = natural_frequencies(bogie, true);
  ASSERT_EQ(found.size(), 5U);
  double furthest = 0;
  for (const double f : found) {
    const auto far = [&](double of) { return std::abs(of - f); };
    furthest = std::max(
        furthest, far(*std::min_element(all.begin(), all.end(),
                                        [&](double a, double b) { return far(a) < far(b); })));
  }
  verified::below(
      "furthest from a mode of the coach", "Hz", furthest,
      {1e-11, "rounding of 13 Hz, 2e-15, times the ratio of eigenvalues, 250, twenty times"});
}

// Axle loads and static deflections of the springs, from the static equilibrium of a passage.
TEST(Vehicle, StaticLoads) {
  const Line line((LineParameters()));
  TrainParameters motion;
  motion.start = 40;
  for (const auto& [name, load] :
       {std::pair{"manchester_1", 109.09e3}, {"alfa_pendular", 132.35e3}}) {
    motion.vehicles = {name};
    const Train train(motion, {}, 2);
    const Passage passage(line, train, WheelRail({}), Irregularity({}, 60), motion, {});
    for (std::size_t i = 0; i < 4; ++i)
      verified::near(fmt::format("{}, axle {}", name, i + 1), "N", 2 * passage.wheel_force(i), load,
                     {5, "five digits of the reference"});
    if (name != std::string("manchester_1")) continue;
    const Vector& u = passage.train_motion().displacement;
    // Unknowns: body z, pitch; bogie z, pitch, wheelset, wheelset; the same for the second bogie.
    const double bogies = (u[2] + u[6]) / 2;
    const verified::Tolerance digits{5e-6, "digits of the reference, 0.01 mm"};
    verified::near("secondary springs", "m", bogies - u[0], 182.51e-3, digits);
    verified::near("primary springs", "m", (u[4] + u[5]) / 2 - u[2], 37.42e-3, digits);
  }
}

// Two axles in the middle of the vehicle, on one rail and on each of two.
TEST(Vehicle, LoadsOfABogieAlone) {
  constexpr double axle = 15.5e3 * 9.81;  // N
  for (const Dimension dimension : {Dimension::plane, Dimension::space}) {
    LineParameters p;
    p.track.dimension = dimension;
    const Line line(p);
    const TrainParameters motion{.vehicles = {"x2_bogie"}, .start = 40};
    const Train train(motion, {}, 2, p.track.wheel_gauge());
    const Passage passage(line, train, WheelRail({}), Irregularity({}, 60), motion, {});
    const std::size_t wheels = 2 * line.sides();
    ASSERT_EQ(train.wheels().size(), wheels);
    for (std::size_t i = 0; i < wheels; ++i)
      verified::near(fmt::format("{}, wheel {}", line.sides() == 1 ? "one rail" : "two rails", i),
                     "N", passage.wheel_force(i), axle / 2,
                     {5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"});
    EXPECT_DOUBLE_EQ(train.axle_distance(), 2.9);
    EXPECT_EQ(train.roll_unknown()[0], dimension == Dimension::space ? 1 : -1);
  }
}

// Yang and Yau 1997, doi:10.1061/(ASCE)0733-9445(1997)123:11(1512): the spring is the contact.
TEST(Vehicle, SprungMassOnASpan) {
  const Line line(span(2.87e9, 2.90, 2303));
  VehicleParameters mass;
  mass.name = "mass";
  mass.kind = VehicleKind::wheel;
  mass.length = 1;
  mass.wheelset_mass = 5750;
  TrainParameters motion{.vehicles = {"mass"}, .speed = 100 / 3.6, .start = 0};
  const Train train(motion, {mass}, 1);
  WheelRailParameters spring;
  spring.law = WheelRailLaw::linear;
  spring.stiffness = 1595e3;
  Passage passage(line, train, WheelRail(spring), Irregularity({}, 25), motion,
                  {.step = 2e-4, .duration = 0.9});
  double largest = 0, when = 0, up = 0, down = 0;
  while (passage.time() < 0.9) {
    passage.advance();
    if (const double w = -passage.rail_displacement(12.5); w > largest)
      largest = w, when = passage.time();
    const double acceleration = passage.train_motion().acceleration[0];
    up = std::max(up, acceleration);
    down = std::min(down, acceleration);
  }
  // The reference has eleven modes; forty elements have more. The deflection under a force is a sum
  // of 1/n^4 over odd n.
  verified::near("largest at mid-span", "m", largest, 2.407405e-3,
                 {5e-7, "modes beyond eleven: 9.5e-5 of 2.4 mm, 2.3e-7 m, twice"});
  verified::near("time of the largest", "s", when, 0.3710, {5e-4, "a step, and four digits"});
  const verified::Tolerance beyond{2e-4, "modes beyond eleven, 2.3e-7 m, times k / m, three times"};
  verified::near("largest acceleration upwards", "m/s2", up, 0.14799, beyond);
  verified::near("largest acceleration downwards", "m/s2", -down, 0.14224, beyond);
}

}  // namespace
}  // namespace trackbed::track::vehicle_test
