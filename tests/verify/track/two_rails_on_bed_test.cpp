// Two rails over moved rigid sleepers: symmetric motion must equal the plane train, other motion
// the track alone in space with the sleepers in its matrix.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/verified.hpp"
#include "trackbed/track/on_bed.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::track::two_rails_on_bed_test {
namespace {

constexpr std::size_t before = 12, count = 17, watched = 8;  // sleepers of the bed; its middle one
constexpr std::size_t below_dip = 3;                         // of the bed, at 9 m of the track
constexpr double duration = 0.22, every = 4e-4;              // s; the second axle is on the bed
constexpr double height = 0.22, width = 0.29;                // m, of a sleeper

const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 0};

// The roll inertia is that of the box.
LineParameters track_of(Dimension dimension) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 24;
  const double length = p.track.sleeper_length;
  if (dimension == Dimension::space)
    p.track.sleeper_inertia = p.track.sleeper_mass * (length * length + height * height) / 12;
  return p;
}

// In the middle of the bed, of the left rail.
IrregularityParameters dip() {
  IrregularityParameters p;
  p.kind = IrregularityKind::versine;
  p.at = 9, p.depth = 2e-3, p.length = 3;
  return p;
}

// A train over a bed of springs with all forces at the same time; half sleepers for one rail, whole
// sleepers for two.
struct OnBed {
  OnBed(Dimension dimension, double dt, const std::optional<IrregularityParameters>& right)
      : step(dt),
        line(track_of(dimension)),
        sides(dimension == Dimension::space ? 2 : 1),
        aside(line.track.wheel_gauge() / 2),
        sleepers({.count = count,
                  .first = 0.6,
                  .width = width,
                  .height = height,
                  .length = line.track.sleeper_length,
                  .density = line.track.sleeper_mass * static_cast<double>(sides) / 2 /
                             (width * height * line.track.sleeper_length),
                  .free = {"z", "rx"},
                  .gauge = line.track.wheel_gauge()},
                 dimension, line.track.sleeper_length, 0),
        train({.line = line,
               .vehicles = {},
               .train = motion,
               .wheel_rail = {},
               .irregularity = dip(),
               .seat = {.before = before, .rails = static_cast<double>(sides)},
               .sleepers = count,
               .first = 0.6,
               .step = dt,
               .irregularity_right = right},
              std::vector<double>(count * sides, 0.0)) {
    sleepers.place(1);
  }

  // N, upwards, of a spring `at` m to the left.
  double spring(std::size_t i, double at) const {
    const Seat foot = seat_of(sleepers, i, at);
    return -line.ballast.stiffness * foot.height - line.ballast.damping * foot.rate;
  }

  // Forces of springs at L/sqrt(12) as forces at both ends with the same sum and moment.
  std::vector<Vec3> bed_of(std::size_t i) const {
    const double length = line.track.sleeper_length;
    const double place = sides == 2 ? length / std::sqrt(12.0) : 0;
    const double left = spring(i, place), right = sides == 2 ? spring(i, -place) : 0;
    std::vector<Vec3> nodes;
    for (const Vec3& node : sleepers_nodes(i)) {
      const double more = (node.y() > 0 ? 1 : -1) * (left - right) * place / (length / 2);
      nodes.emplace_back(0, 0, (left + right + more) / 8);
    }
    return nodes;
  }

  std::vector<Vec3> sleepers_nodes(std::size_t i) const {
    return const_cast<RigidSleepers&>(sleepers).surfaces()[i].position;
  }

  // As Simulation::move_sleepers.
  void window() {
    std::vector<double> pads, levels, rates;
    std::vector<std::vector<Vec3>> nodes;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t side = 0; side < sides; ++side) pads.push_back(train.seat_force(i, side));
      nodes.push_back(bed_of(i));
    }
    sleepers.advance(step, pads, {nodes.begin(), nodes.end()}, 0);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t side = 0; side < sides; ++side) {
        const Seat seat = seat_of(sleepers, i, side == 0 ? aside : -aside);
        levels.push_back(seat.height), rates.push_back(seat.rate);
      }
    train.advance(levels, rates);
  }

  double step;
  LineParameters line;
  std::size_t sides;
  double aside;  // m
  RigidSleepers sleepers;
  TrainOnBed train;
};

// Every 0.4 ms: N, of the first axle's wheels; m, of the seats of the sleeper in the middle.
struct Histories {
  std::vector<double> wheel, wheels_apart, sleeper, seats_apart;
  void add(double left, double right, double seat, double other) {
    wheel.push_back(left + right), wheels_apart.push_back(left - right);
    sleeper.push_back(seat + other), seats_apart.push_back(seat - other);
  }
};

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double largest(const std::vector<double>& of) {
  double most = 0;
  for (const double one : of) most = std::max(most, std::abs(one));
  return most;
}

Histories alone(double dt) {
  const Line line(track_of(Dimension::space));
  const Train train(motion, {}, 2, line.gauge());
  Passage passage(line, train, WheelRail({}), Irregularity(dip(), 24), motion, {.step = dt},
                  Irregularity({}, 24));
  Histories found;
  for (int i = 1; i <= std::lround(duration / dt); ++i) {
    passage.advance();
    if (i % std::lround(every / dt) != 0) continue;
    const Vector& u = passage.line_motion().displacement;
    found.add(passage.wheel_force(0), passage.wheel_force(1),
              u[line.sleeper_unknown(before + watched, 0)],
              u[line.sleeper_unknown(before + watched, 1)]);
  }
  return found;
}

Histories on_bed(double dt) {
  OnBed model(Dimension::space, dt, IrregularityParameters{});
  Histories found;
  for (int i = 1; i <= std::lround(duration / dt); ++i) {
    model.window();
    if (i % std::lround(every / dt) != 0) continue;
    const Passage& passage = model.train.passage();
    found.add(passage.wheel_force(0), passage.wheel_force(1),
              seat_of(model.sleepers, watched, model.aside).height,
              seat_of(model.sleepers, watched, -model.aside).height);
  }
  return found;
}

// Bounce and roll separately: a dip of one rail excites both.
TEST(TwoRailsOnBed, ConvergeToTheTrackAlone) {
  const Histories coarsest = alone(2e-4), coarse = alone(1e-4), fine = alone(5e-5);
  const Histories start = on_bed(2e-4), a = on_bed(1e-4), b = on_bed(5e-5);
  const verified::Limit rolls{5e3, "separates: the dip of one rail excites roll"};
  verified::above("largest difference of left and right wheel", "N", largest(fine.wheels_apart),
                  rolls);
  verified::above("largest difference of left and right seat", "m", largest(fine.seats_apart),
                  {2e-5, "separates: the dip of one rail excites roll"});
  const verified::Tolerance order{0.15, "second order; wheels pass from element to element, 1.4"};
  const verified::Tolerance coarser{
      0.3, "second order; wheels pass from element to element, 1.4; windows twice as long"};
  const auto check = [&](const std::string& of, auto member) {
    const double first = distance(start.*member, coarsest.*member),
                 second = distance(a.*member, coarse.*member),
                 third = distance(b.*member, fine.*member);
    verified::near("order in the window, " + of, "-", std::log2(second / third), 2, order);
    verified::near("order from windows of 0.2 to 0.1 ms, " + of, "-", std::log2(first / second), 2,
                   coarser);
  };
  check("sleeper's bounce", &Histories::sleeper);
  check("sleeper's roll", &Histories::seats_apart);
  check("sum of an axle's wheels", &Histories::wheel);
  check("difference of its wheels", &Histories::wheels_apart);
  verified::below(
      "seats against the track alone, windows of 0.05 ms, root mean square of their "
      "difference",
      "m", distance(b.seats_apart, fine.seats_apart),
      {5e-10, "guards the factor beside the order: 1.5e-10 m, three times"});
  verified::below("difference of wheels against the track alone", "N",
                  distance(b.wheels_apart, fine.wheels_apart),
                  {0.5, "guards the factor beside the order: 0.14 N, three times"});
}

// Twice the sleeper mass on twice the spring stiffness.
TEST(TwoRailsOnBed, UnderASymmetricLoadAreThePlaneTrain) {
  OnBed space(Dimension::space, 2e-4, {}), plane(Dimension::plane, 2e-4, {});
  double wheel = 0, seat = 0, sleeper = 0, roll = 0, most = 0;
  for (int i = 0; i < 1000; ++i) {
    space.window(), plane.window();
    for (std::size_t axle = 0; axle < 4; ++axle)
      for (std::size_t side = 0; side < 2; ++side)
        wheel = std::max(wheel, std::abs(space.train.passage().wheel_force(2 * axle + side) -
                                         plane.train.passage().wheel_force(axle)));
    const double pads = plane.train.seat_force(below_dip);
    for (std::size_t side = 0; side < 2; ++side)
      seat = std::max(seat, std::abs(space.train.seat_force(below_dip, side) - pads));
    most = std::max(most, pads);
    sleeper = std::max(sleeper, std::abs(space.sleepers.state(below_dip).displacement.z() -
                                         plane.sleepers.state(below_dip).displacement.z()));
    roll = std::max(roll, std::abs(space.sleepers.state(below_dip).rotation.x()));
  }
  const verified::Limit contacts{5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"};
  const verified::Limit converged{4e-12, "contacts converge to 1e-12 m, four times"};
  verified::above("largest force of a seat", "N", most, {20e3, "separates: the train loads it"});
  verified::below("largest difference of a wheel force", "N", wheel, contacts);
  verified::below("largest difference of a seat's force", "N", seat, contacts);
  verified::below("largest difference of a sleeper", "m", sleeper, converged);
  verified::below("largest roll of a sleeper", "rad", roll, converged);
}

// Forces of rails and sleepers are equal: without its bed, the rates of a sleeper's momentum and
// angular momentum are the sum and the moment of its seat forces.
TEST(TwoRailsOnBed, SeatForcesMoveTheSleepers) {
  OnBed model(Dimension::space, 1e-4, IrregularityParameters{});
  for (int i = 0; i < 1900; ++i) model.window();
  const double mass = model.sleepers.mass(), length = model.line.track.sleeper_length;
  const double inertia = mass * (length * length + height * height) / 12;
  const double left = model.train.seat_force(below_dip, 0),
               right = model.train.seat_force(below_dip, 1);
  const SleeperState was = model.sleepers.state(below_dip);
  std::vector<double> pads;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t side = 0; side < 2; ++side) pads.push_back(model.train.seat_force(i, side));
  model.sleepers.advance(model.step, pads, {}, 0);
  const SleeperState now = model.sleepers.state(below_dip);
  const verified::Tolerance rounding{
      1e-8, "leapfrog: exact, but for rounding and the turn of levers, (2e-5 rad)^2 / 2 = 2e-10"};
  verified::above("left seat over right seat", "N", std::abs(left - right),
                  {500, "separates: both seats differ"});
  const double force = mass * (now.velocity.z() - was.velocity.z()) / model.step;
  const double moment = inertia * (now.spin.x() - was.spin.x()) / model.step;
  verified::near("change of momentum", "N", force, -left - right, rounding.of(left));
  const double turned = (right - left) * model.line.track.gauge / 2;
  verified::near("change of angular momentum", "N m", moment, turned, rounding.of(turned));
  EXPECT_EQ(model.train.seat_force(below_dip), left + right);
}

}  // namespace
}  // namespace trackbed::track::two_rails_on_bed_test
