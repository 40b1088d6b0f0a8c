// Vehicles: frequencies, loads at rest, and a mass on a spring that crosses a bridge.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track {
namespace {

const VehicleParameters& of_library(const std::string& name) {
  for (const VehicleParameters& v : vehicle_library())
    if (v.name == name) return v;
  throw std::runtime_error(name);
}

// References have four decimals.
TEST(Vehicle, FrequenciesOfTheManchesterVehicle) {
  const std::vector<double> expected = {1.0739, 1.2991, 7.4705, 7.4772, 11.7138, 11.7138};
  const std::vector<double> found = natural_frequencies(of_library("manchester_1"));
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    verified::near(fmt::format("mode {}", i + 1), "Hz", found[i], expected[i], 6e-5);
}

// Axle loads and static sag of the springs, from the equilibrium a passage begins in.
TEST(Vehicle, LoadsAtRest) {
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
                     10);
    if (name != std::string("manchester_1")) continue;
    const Vector& u = passage.train_motion().displacement;
    // Unknowns: body z, pitch; bogie z, pitch, wheelset, wheelset; the same again.
    const double bogies = (u[2] + u[6]) / 2;
    verified::near("secondary springs", "m", bogies - u[0], 182.51e-3, 1e-5);
    verified::near("primary springs", "m", (u[4] + u[5]) / 2 - u[2], 37.42e-3, 1e-5);
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
  // The reference has eleven modes; ten elements have more.
  verified::near("largest at mid-span", "m", largest, 2.407405e-3, 1e-6);
  verified::near("time of the largest", "s", when, 0.3710, 1e-3);
  verified::near("largest acceleration upwards", "m/s2", up, 0.14799, 1e-3);
  verified::near("largest acceleration downwards", "m/s2", -down, 0.14224, 1e-3);
}

}  // namespace
}  // namespace trackbed::track
