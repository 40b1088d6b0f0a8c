// Green's functions superposed along the path of wheels against a passage of constant forces.
#include "trackbed/track/greens.hpp"

#include <gtest/gtest.h>

#include "trackbed/track/passage.hpp"

namespace trackbed::track::greens_test {
namespace {

constexpr double rate = 2000, speed = 40;  // Hz, m/s

// Relative to the largest value: both are sums of the same numbers in another order.
constexpr double rounding = 1e-11;

LineParameters track(Dimension dimension) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 12;
  p.track.run_in = 0;
  p.track.zones = {{.from = 5, .to = 8, .rail = 3}};
  return p;
}

GreensParameters functions() {
  GreensParameters p;
  p.sensor = 6;
  p.rate = rate;
  p.duration = 0.6;  // the whole passage
  p.speed = speed;
  p.axles = {0, 2.5};
  p.step = 1 / rate;  // the force of one step of the passage
  return p;
}

// Two axles of constant force enter the track at rest.
struct ForcesOnTrack {
  explicit ForcesOnTrack(Dimension dimension)
      : line(track(dimension)),
        train(motion(), vehicles(), 2, dimension == Dimension::space ? 1.5 : 0),
        passage(line, train, WheelRail({}), Irregularity({}, 12), motion(), steps()) {}

  static TrainParameters motion() {
    TrainParameters p;
    p.vehicles = {"two"};
    p.speed = speed;
    p.start = -0.01;
    return p;
  }
  static std::vector<VehicleParameters> vehicles() {
    VehicleParameters two;
    two.name = "two";
    two.kind = VehicleKind::forces;
    two.length = 5;
    two.axles = {1, 3.5};
    two.loads = {1e5, 6e4};
    return {two};
  }
  static PassageParameters steps() {
    PassageParameters p;
    p.step = 1 / rate;
    return p;
  }

  Line line;
  Train train;
  Passage passage;
};

struct Path {
  std::vector<double> x;      // m, of the wheel in each step, from the first one on
  std::vector<double> force;  // N
};

// What a wheel on the left rail does in all steps, as long as it is on the track.
Path path_of(const ForcesOnTrack& run, std::size_t wheel, std::size_t steps) {
  Path path;
  for (std::size_t n = 1; n <= steps; ++n) {
    const double x = ForcesOnTrack::motion().start + speed * static_cast<double>(n) / rate -
                     run.train.wheels()[wheel].behind;
    path.x.push_back(x);
    path.force.push_back(x >= 0 && x <= run.line.length() ? run.train.wheels()[wheel].force : 0);
  }
  return path;
}

TEST(GreensFunctions, OfTheSleeperGiveThePassageOfForces) {
  for (const Dimension dimension : {Dimension::plane, Dimension::space}) {
    ForcesOnTrack run(dimension);
    const GreensFunctions greens(run.line, functions());
    constexpr std::size_t steps = 500;
    std::vector<double> expected(steps, 0), accelerated(steps, 0);
    for (std::size_t wheel = 0; wheel < run.train.wheels().size(); ++wheel) {
      const Path path = path_of(run, wheel, steps);
      const GreensFunctions::Fixed to = greens.fixed(path.x, run.train.wheels()[wheel].side);
      for (std::size_t from = 0; from < steps; ++from)
        for (std::size_t n = from; n < steps; ++n) {
          const auto i = static_cast<Eigen::Index>(from), lag = static_cast<Eigen::Index>(n - from);
          expected[n] -= path.force[from] * to.displacement(i, lag);
          accelerated[n] -= path.force[from] * to.acceleration(i, lag);
        }
    }
    const std::int32_t sensor = run.line.sleeper_unknown(run.line.nearest_sleeper(6));
    double lowest = 0, error = 0, largest = 0, error_of_acceleration = 0;
    for (std::size_t n = 0; n < steps; ++n) {
      run.passage.advance();
      const Newmark& motion = run.passage.line_motion();
      lowest = std::min(lowest, motion.displacement[sensor]);
      largest = std::max(largest, std::abs(motion.acceleration[sensor]));
      error = std::max(error, std::abs(motion.displacement[sensor] - expected[n]));
      error_of_acceleration =
          std::max(error_of_acceleration, std::abs(motion.acceleration[sensor] - accelerated[n]));
    }
    EXPECT_LT(lowest, -1e-4);
    EXPECT_LT(error, rounding * -lowest);
    EXPECT_LT(error_of_acceleration, rounding * largest);
  }
}

// On two rails the wheels of both deflect the rail below the first right wheel.
TEST(GreensFunctions, OfTheRailBelowAWheelGiveThePassageOfForces) {
  for (const std::size_t side : {0, 1}) {
    ForcesOnTrack run(side == 0 ? Dimension::plane : Dimension::space);
    GreensParameters parameters = functions();
    parameters.side = side;
    parameters.duration = 0.1;
    const GreensFunctions greens(run.line, parameters);
    constexpr std::size_t steps = 200;
    std::vector<double> expected(steps, 0);
    for (std::size_t wheel = 0; wheel < run.train.wheels().size(); ++wheel) {
      const Path path = path_of(run, wheel, steps);
      const Columns to =
          greens.moving(path.x, run.train.wheels()[wheel].axle, run.train.wheels()[wheel].side);
      for (std::size_t from = 0; from < steps; ++from)
        for (std::size_t n = from; n < steps; ++n)
          expected[n] -= path.force[from] *
                         to(static_cast<Eigen::Index>(from), static_cast<Eigen::Index>(n - from));
    }
    double lowest = 0, error = 0;
    for (const double before : expected) {
      run.passage.advance();
      const double x = run.passage.wheel_x(side);
      const bool on = x >= 0 && x <= run.line.length();
      // The local deflection below a force is not that of the shape functions.
      const double rail = run.passage.rail_displacement(x, side) -
                          (on ? run.passage.wheel_force(side) * run.line.at(x, side).local : 0);
      lowest = std::min(lowest, rail);
      error = std::max(error, std::abs(rail - before));
    }
    EXPECT_LT(lowest, -1e-4);
    EXPECT_LT(error, rounding * -lowest);
  }
}

// A pulse over a sample in 50 and in 100 steps.
TEST(GreensFunctions, DoNotDependOnTheStep) {
  const Line line(track(Dimension::plane));
  GreensParameters fine = functions();
  fine.step = 1e-5;
  GreensParameters finer = fine;
  finer.step = 5e-6;
  const std::vector<double> x{5.1, 6.3};
  const Columns one = GreensFunctions(line, fine).fixed(x, 0).displacement;
  const Columns other = GreensFunctions(line, finer).fixed(x, 0).displacement;
  EXPECT_EQ(one.cols(), 1201);
  EXPECT_LT((one - other).cwiseAbs().maxCoeff(), 1e-4 * one.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace trackbed::track::greens_test
