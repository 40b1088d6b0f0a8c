// Position of a train: the integral of its speeds, and its inverse.
#include "trackbed/track/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "trackbed/track/passage.hpp"
#include "unit/bed/rules.hpp"

namespace trackbed::track::motion_test {
namespace {

// Brakes to a stop, waits, and accelerates.
TrainParameters stop_and_go() {
  return {.vehicles = {"manchester_1"},
          .speed = 20,
          .start = -5,
          .times = {1, 5, 8, 12},
          .speeds = {20, 0, 0, 10}};
}

TEST(Motion, IsLinearAtConstantSpeed) {
  const Motion motion({.speed = 50, .start = 10});
  EXPECT_EQ(motion.x(0), 10);
  EXPECT_EQ(motion.x(0.4), 30);
  EXPECT_EQ(motion.speed(7), 50);
  EXPECT_EQ(motion.time_at(60), 1);
  EXPECT_EQ(motion.time_at(-3), 0);
}

// 20 m/s for 1 s, 4 s of braking: 20 + 40 m; from rest in 4 s to 10 m/s: 20 m.
TEST(Motion, IntegratesSpeeds) {
  const Motion motion(stop_and_go());
  EXPECT_DOUBLE_EQ(motion.x(1), 15);
  EXPECT_DOUBLE_EQ(motion.x(3), 15 + 20 * 2 - 5 * 2 * 2 / 2.0);
  EXPECT_DOUBLE_EQ(motion.x(5), 55);
  EXPECT_DOUBLE_EQ(motion.x(7.3), 55);
  EXPECT_DOUBLE_EQ(motion.x(12), 75);
  EXPECT_DOUBLE_EQ(motion.x(20), 155);
  EXPECT_DOUBLE_EQ(motion.speed(3), 10);
  EXPECT_EQ(motion.speed(6), 0);
  EXPECT_EQ(motion.speed(30), 10);
}

TEST(Motion, TimeAtAPositionIsTheInverse) {
  const Motion motion(stop_and_go());
  for (const double time : {0.0, 0.5, 1.0, 2.0, 4.5, 9.0, 12.0, 20.0})
    EXPECT_NEAR(motion.time_at(motion.x(time)), time, 1e-12);
  EXPECT_NEAR(motion.time_at(55), 5, 1e-6);  // where it waits: the time of arrival
  TrainParameters stops = stop_and_go();
  stops.times.resize(2), stops.speeds.resize(2);
  EXPECT_DOUBLE_EQ(Motion(stops).time_at(55), 5);
  EXPECT_EQ(Motion(stops).time_at(55.1), INFINITY);
}

// With equal speeds at all times the results are those of a constant speed, to rounding.
TEST(Motion, EqualSpeedsAreAConstantSpeed) {
  const TrainParameters one{.vehicles = {"manchester_1"}, .speed = 50, .start = 20};
  TrainParameters many = one;
  many.times = {0.01, 0.03}, many.speeds = {50, 50};
  const Line line(LineParameters{});
  const Train train(one, {}, 2);
  const Irregularity none({}, 60);
  Passage a(line, train, WheelRail({}), none, one, {}),
      b(line, train, WheelRail({}), none, many, {});
  for (int i = 0; i < 200; ++i) a.advance(), b.advance();
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    EXPECT_NEAR(a.wheel_x(wheel), b.wheel_x(wheel), 1e-13);
    EXPECT_NEAR(a.wheel_force(wheel), b.wheel_force(wheel), 1e-3);  // contacts to 1e-12 m
  }
  EXPECT_NEAR(a.duration(), b.duration(), 1e-13);
}

TEST(Motion, InvalidTablesAreRefused) {
  using Names = std::set<std::string>;
  const auto broken = [](std::vector<double> times, std::vector<double> speeds, double speed = 50) {
    TrainParameters p;
    p.speed = speed, p.times = std::move(times), p.speeds = std::move(speeds);
    return BrokenRules::of(p);
  };
  EXPECT_EQ(broken({20, 40}, {0, 50}), Names{});
  EXPECT_EQ(broken({40, 20}, {0, 50}), Names{"times"});
  EXPECT_EQ(broken({20, 20}, {0, 50}), Names{"times"});
  EXPECT_EQ(broken({20}, {}), Names{"speeds"});
  EXPECT_EQ(broken({1}, {0}), Names{"speeds"});  // by 50 m/s2: a warning
  EXPECT_EQ(broken({}, {}, 0), Names{});  // stands; the duration is checked elsewhere (warnings)
  EXPECT_EQ(broken({20}, {10}, 0), Names{});
}

}  // namespace
}  // namespace trackbed::track::motion_test
