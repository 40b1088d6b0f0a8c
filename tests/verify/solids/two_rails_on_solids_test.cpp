// Two rails over whole solid sleepers on springs: symmetric results must equal the plane train,
// roll must equal that of the track alone in space, which has rigid sleepers in its matrix, and no
// window generates energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/verified.hpp"
#include "trackbed/fem/bodies.hpp"
#include "trackbed/track/on_bed.hpp"

namespace trackbed::fem::two_rails_on_solids_test {
namespace {

constexpr std::size_t before = 12, count = 17, watched = 8;  // sleepers of the bed; its middle one
constexpr std::size_t below_dip = 3;                         // of the bed, at 9 m of the track
constexpr double duration = 0.22, every = 4e-4;              // s; the second axle reaches the bed
constexpr double width = 0.29, height = 0.22;                // m

const track::TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 0};

// The roll inertia is that of the box.
track::LineParameters track_of(Dimension dimension) {
  track::LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 24;
  const double length = p.track.sleeper_length;
  if (dimension == Dimension::space)
    p.track.sleeper_inertia = p.track.sleeper_mass * (length * length + height * height) / 12;
  return p;
}

// A dip at the middle of the bed.
track::IrregularityParameters dip(double depth) {
  track::IrregularityParameters p;
  p.kind = track::IrregularityKind::versine;
  p.at = 9, p.depth = depth, p.length = 3;
  return p;
}

struct Case {
  Dimension dimension = Dimension::space;
  double dt = 2e-4;     // s
  double stiffer = 1;   // Young's modulus over that of concrete
  double alpha = -0.1;  // of Bossak's scheme
  double right = 2e-3;  // m, depth of the right rail's dip; of the left one 2 mm
  bool joined = true;   // seats deflect under each other's forces
  bool vehicles = true;
  track::LineParameters line = track_of(dimension);
};

// Whole sleepers on vertical springs, so that roll is that of a sleeper without lateral
// displacement; sleeper i on the fixed block count + i.
BodiesParameters solids(const Case& c) {
  const track::TrackParameters& track = c.line.track;
  const double length = track.sleeper_length,
               density = track.sleeper_mass / (width * height * length);
  BodiesParameters p;
  p.alpha = c.alpha;
  for (const bool base : {false, true})
    for (std::size_t i = 0; i < count; ++i) {
      const double x = static_cast<double>(i) * track.spacing, z = base ? -height : 0;
      p.bodies.push_back({.name = "sleeper",
                          .low = {x - width / 2, -length / 2, z},
                          .high = {x + width / 2, length / 2, z + height},
                          .elements = {1, base ? 1 : 8, 1},
                          .solid = {.young = c.stiffer * 37e9, .poisson = 0, .density = density},
                          .touched = !base});
    }
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) * track.spacing;
    const Vec3 directions(1, 0, 2);
    p.pads.push_back(
        {.below = count + i,
         .above = i,
         .patch = {.x = {x - width / 2, x + width / 2}, .y = {-length / 2, length / 2}},
         .stiffness = c.line.ballast.stiffness * directions,
         .damping = c.line.ballast.damping * directions});
    for (const bool low : {true, false})
      p.held.push_back(
          {.body = count + i, .axis = 0, .low = low, .components = {true, true, true}});
  }
  return p;
}

// Coupled as in model::SolidSleepers and model::StageTrain. With one rail its pad acts on both
// seats.
struct OnSolids {
  explicit OnSolids(const Case& given)
      : c(given),
        sides(c.dimension == Dimension::space ? 2 : 1),
        bodies(solids(c)),
        train(train_of()) {
    bodies.place(Vec3::Zero());
  }

  NodeWeights seat_at(std::size_t i, double y) const {
    const double x = static_cast<double>(i) * c.line.track.spacing;
    return bodies.over(i, Side::upper, {.x = {x - 0.07, x + 0.07}, .y = {y - 0.07, y + 0.07}});
  }

  track::TrainOnBed train_of() {
    std::vector<track::Matrix2> mobility(count, track::Matrix2::Zero());
    const double aside = c.line.track.gauge / 2;
    for (std::size_t i = 0; i < count; ++i) {
      const NodeWeights left = seat_at(i, aside), right = seat_at(i, -aside);
      if (sides == 1) {
        NodeWeights both;
        for (const NodeWeights& seat : {left, right})
          for (const NodeWeight& one : seat) both.push_back({one.node, one.weight / 2});
        mobility[i](0, 0) = bodies.mobility(c.dt, both);
        seats.push_back(both);
        continue;
      }
      mobility[i](0, 0) = bodies.mobility(c.dt, left);
      mobility[i](1, 1) = bodies.mobility(c.dt, right);
      if (c.joined) mobility[i](0, 1) = mobility[i](1, 0) = bodies.mobility(c.dt, left, right);
      seats.push_back(left), seats.push_back(right);
    }
    track::TrainParameters sent = motion;
    if (!c.vehicles) sent.vehicles = {};
    return track::TrainOnBed({.line = c.line,
                              .vehicles = {},
                              .train = sent,
                              .wheel_rail = {},
                              .irregularity = dip(2e-3),
                              .seat = {.before = before, .rails = 2},
                              .sleepers = count,
                              .first = 0.6,
                              .step = c.dt,
                              .mobility = mobility,
                              .irregularity_right = dip(c.right)},
                             std::vector<double>(count * sides, 0.0));
  }

  void window(std::span<const Bodies::PatchLoad> also = {}) {
    bodies.advance(c.dt, 0, also, {});
    std::vector<double> levels, rates;
    for (const NodeWeights& seat : seats) {
      levels.push_back(bodies.trapezoidal(c.dt, seat).z());
      rates.push_back(bodies.velocity(seat).z());
    }
    train.advance(levels, rates);
    std::vector<Bodies::PatchLoad> pushes;
    for (std::size_t k = 0; k < seats.size(); ++k)
      pushes.push_back({seats[k], {0, 0, -train.seat_force(k / sides, k % sides)}});
    bodies.add_loads(pushes);
  }

  // N, residual of the law of a pad for the present state of rail and seat.
  double off_law(std::size_t i, std::size_t side) const {
    const track::Newmark& rail = train.passage().line_motion();
    const track::RailPoint at = train.line().at(train.line().sleeper_x(before + i), side);
    const NodeWeights& seat = seats[i * sides + side];
    const double compression =
                     bodies.trapezoidal(c.dt, seat).z() - at.deflection(rail.displacement),
                 rate = bodies.velocity(seat).z() - at.deflection(rail.velocity);
    const double zone =
        c.line.track.factor(&track::TrackZone::pad, train.line().sleeper_x(before + i), side);
    return train.seat_force(i, side) -
           zone * (c.line.pad.stiffness * compression + c.line.pad.damping * rate);
  }

  Case c;
  std::size_t sides;
  Bodies bodies;
  std::vector<NodeWeights> seats;
  track::TrainOnBed train;
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

Histories alone(double dt, double right) {
  const track::Line line(track_of(Dimension::space));
  const track::Train train(motion, {}, 2, line.gauge());
  track::Passage passage(line, train, track::WheelRail({}), track::Irregularity(dip(2e-3), 24),
                         motion, {.step = dt}, track::Irregularity(dip(right), 24));
  Histories found;
  for (int i = 1; i <= std::lround(duration / dt); ++i) {
    passage.advance();
    if (i % std::lround(every / dt) != 0) continue;
    const track::Vector& u = passage.line_motion().displacement;
    found.add(passage.wheel_force(0), passage.wheel_force(1),
              u[line.sleeper_unknown(before + watched, 0)],
              u[line.sleeper_unknown(before + watched, 1)]);
  }
  return found;
}

Histories on_solids(const Case& c) {
  OnSolids model(c);
  Histories found;
  for (int i = 1; i <= std::lround(duration / c.dt); ++i) {
    model.window();
    if (i % std::lround(every / c.dt) != 0) continue;
    found.add(model.train.passage().wheel_force(0), model.train.passage().wheel_force(1),
              model.bodies.displacement(model.seats[2 * watched]).z(),
              model.bodies.displacement(model.seats[2 * watched + 1]).z());
  }
  return found;
}

// Flexible sleepers: the plane train has the same ones, whose two seats share the force of its pad.
TEST(TwoRailsOnSolids, UnderASymmetricLoadEqualThePlaneTrain) {
  OnSolids space({}), plane({.dimension = Dimension::plane});
  double wheel = 0, seat = 0, level = 0, most = 0;
  for (int i = 0; i < std::lround(duration / space.c.dt); ++i) {
    space.window(), plane.window();
    for (std::size_t axle = 0; axle < 4; ++axle)
      for (std::size_t side = 0; side < 2; ++side)
        wheel = std::max(wheel, std::abs(space.train.passage().wheel_force(2 * axle + side) -
                                         plane.train.passage().wheel_force(axle)));
    const double pads = plane.train.seat_force(below_dip) / 2;
    most = std::max(most, pads);
    for (std::size_t side = 0; side < 2; ++side) {
      seat = std::max(seat, std::abs(space.train.seat_force(below_dip, side) - pads));
      level = std::max(level, std::abs(space.train.seat_displacement(below_dip, side) -
                                       plane.train.seat_displacement(below_dip, 0)));
    }
  }
  const verified::Limit contacts{1e-3, "contacts converge to 1e-12 m at 1e9 N/m: 1 mN"};
  verified::above("largest force of a seat", "N", most, {20e3, "separates: the train loads it"});
  verified::below("largest difference of a wheel force", "N", wheel, contacts);
  verified::below("largest difference of a seat's force", "N", seat, contacts);
  verified::below("largest difference of a seat", "m", level,
                  {4e-12, "contacts converge to 1e-12 m, four times"});
}

// The right rail has a crest where the left one has a dip. With alpha 0 the step is that of the
// track alone, and the remaining difference is the deformation of the stiff sleepers: a hundredth
// if they are a hundred times as stiff.
TEST(TwoRailsOnSolids, StiffSleepersRollLikeThoseOfTheTrackAlone) {
  const Histories rigid = alone(2e-4, -2e-3);
  const Histories stiff = on_solids({.stiffer = 1e4, .alpha = 0, .right = -2e-3}),
                  soft = on_solids({.stiffer = 1e2, .alpha = 0, .right = -2e-3});
  const verified::Limit rolls{5e3, "separates: the axles roll"};
  verified::above("largest difference of left and right wheel", "N", largest(rigid.wheels_apart),
                  rolls);
  verified::above("largest difference of left and right seat", "m", largest(rigid.seats_apart),
                  {2e-5, "separates: the sleeper rolls"});
  verified::below("difference of wheels, 1e4 E against rigid, root mean square", "N",
                  distance(stiff.wheels_apart, rigid.wheels_apart),
                  {0.1, "deformation: 0.03 N, three times; contacts converge to 1 mN"});
  verified::below("difference of seats, 1e4 E against rigid, root mean square", "m",
                  distance(stiff.seats_apart, rigid.seats_apart),
                  {2e-10, "deformation: F l^3 / 400 E I = 1.5 um with E, 1e-4 of it"});
  const verified::Tolerance inverse{
      1e-3, "first order in 1/E; contacts converge to 1e-12 of 4e-11 m: 2.5e-4, four times"};
  verified::near("difference of seats with 1e4 E over that with 1e2 E", "-",
                 distance(stiff.seats_apart, rigid.seats_apart) /
                     distance(soft.seats_apart, rigid.seats_apart),
                 1e-2, inverse);
  verified::near("sum of seats with 1e4 E over that with 1e2 E", "-",
                 distance(stiff.sleeper, rigid.sleeper) / distance(soft.sleeper, rigid.sleeper),
                 1e-2, inverse);
}

// Largest residual of the pad law over all pads and windows, over the largest force.
double off_law(bool joined, const std::vector<track::TrackZone>& zones = {}) {
  Case given{.dt = 1e-3, .right = -2e-3, .joined = joined};
  given.line.track.zones = zones;
  OnSolids model(given);
  double off = 0, force = 0;
  for (int n = 0; n < std::lround(duration / model.c.dt); ++n) {
    model.window();
    for (std::size_t k = 0; k < 2 * count; ++k) {
      off = std::max(off, std::abs(model.off_law(k / 2, k % 2)));
      force = std::max(force, std::abs(model.train.seat_force(k / 2, k % 2)));
    }
  }
  EXPECT_GT(force, 1e4);
  return off / force;
}

// With the mobility of each seat alone, pads would not include the effect of the other seat's
// force.
TEST(TwoRailsOnSolids, PadForcesAreThoseAtTheEndOfTheWindow) {
  verified::below(
      "residual of the pad law, windows of 1 ms", "-", off_law(true),
      {4e-14, "rounding of 1 mm and 1 m/s times spring and dashpot, 1e-14 of the force"});
  const double middle = static_cast<double>(before + count / 2) * 0.6;
  verified::below(
      "the same, pads of the left rail half as stiff over half of the bed", "-",
      off_law(true, {{.from = 0, .to = middle, .pad = 0.5, .side = track::ZoneSide::left}}),
      {4e-14, "as above"});
  verified::above("residual of the pad law without mutual deflection of seats", "-", off_law(false),
                  {1e-2, "separates: without it forces are wrong by percents"});
}

// Largest displacement of a seat in the last 500 of 1000 windows after an impulse on it, over that
// in the first 500.
double late_over_early(const Case& c) {
  OnSolids model(c);
  const Bodies::PatchLoad blow{model.seats[2 * watched], {0, 0, -1e5}};
  model.window(std::span(&blow, 1));
  double early = 0, late = 0;
  constexpr int windows = 1000;
  for (int n = 0; n < windows; ++n) {
    model.window();
    const double found = std::abs(model.bodies.displacement(model.seats[2 * watched]).z());
    (n < windows / 2 ? early : late) = std::max(n < windows / 2 ? early : late, found);
  }
  return late / early;
}

Case light(double length, double alpha, double dt, bool damped) {
  Case c{.dt = dt, .alpha = alpha, .vehicles = false};
  c.line.track.sleeper_mass = 3, c.line.track.sleeper_inertia = 0;
  c.line.track.sleeper_length = length;
  if (!damped) c.line.pad.damping = c.line.ballast.damping = 0;
  return c;
}

// As for one rail: sleepers come to rest, or without dashpots their amplitude does not grow.
TEST(TwoRailsOnSolids, AnyWindowIsStable) {
  for (const double length : {1.7, 2.6})
    for (const double alpha : {0.0, -0.1, -1.0 / 3})
      for (const double dt : {1e-4, 1e-2, 1.0})
        for (const bool damped : {true, false})
          EXPECT_LE(late_over_early(light(length, alpha, dt, damped)), 1)
              << length << " m, alpha " << alpha << ", dt " << dt << ", damped " << damped;
  Case apart = light(1.7, 0, 1e-2, false);
  apart.joined = false;
  EXPECT_GT(late_over_early(apart), 10);
}

}  // namespace
}  // namespace trackbed::fem::two_rails_on_solids_test
