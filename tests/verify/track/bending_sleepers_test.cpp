// Bending sleepers in the track: stiff ones against rigid ones, a half against a whole one, hanging
// sleepers and sleepers on moved ground.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::bending_sleepers_test {
namespace {

// The contact of wheel and rail has 1.3e9 N/m.
const verified::Limit contacts{5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"};

enum class Dip { left, both };

// A coach over a dip; a dip of the left rail only excites roll.
struct Coach {
  Coach(const TrackParameters& t, double step, Dip of = Dip::left)
      : line(track_of(t)),
        train(motion, {}, 2, t.dimension == Dimension::space ? t.gauge : 0),
        passage(line, train, WheelRail({}), dip(), motion, {.step = step},
                of == Dip::left ? std::optional(Irregularity({}, 36)) : std::nullopt) {}
  static LineParameters track_of(TrackParameters t) {
    LineParameters p;
    t.length = 36;
    p.track = t;
    return p;
  }
  static Irregularity dip() {
    IrregularityParameters p;
    p.kind = IrregularityKind::versine;
    p.at = 22, p.length = 3;
    return {p, 36};
  }
  TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 19};
  Line line;
  Train train;
  Passage passage;
};

// The Euler-Bernoulli beam has the roll inertia of a thin bar, like rigid sleepers.
TEST(BendingSleepers, EqualRigidOnesIfTheyAreStiff) {
  TrackParameters rigid;
  rigid.dimension = Dimension::space;
  rigid.sleeper_length = 2.5;
  rigid.sleeper.unsupported = 0.4;
  const auto difference = [&](double stiffer) {
    TrackParameters t = bending(6);
    t.sleeper.unsupported = 0.4;
    t.sleeper.young *= stiffer;
    Coach one(rigid, 2e-4), other(t, 2e-4);
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      one.passage.advance(), other.passage.advance();
      for (std::size_t wheel = 0; wheel < 8; ++wheel)
        sum = std::max(sum,
                       std::abs(one.passage.wheel_force(wheel) - other.passage.wheel_force(wheel)));
    }
    return sum;
  };
  const double soft = difference(1), stiff = difference(1e3), stiffer = difference(1e4);
  verified::above("largest difference of a wheel force, as stiff as sleepers are", "N", soft,
                  {50, "separates: bending has an effect"});
  const verified::Limit flexible{
      2e-4, "first order in the flexibility: 1e-4 of the difference above, twice"};
  verified::below("ten thousand times as stiff", "N", stiffer, flexible.of(soft));
  verified::near("order in their flexibility", "-", std::log10(stiff / stiffer), 1,
                 {0.05, "first order; contacts converge to 1 mN of 34 mN: 0.04"});
  verified::near("order in their flexibility, 1 to 1000 times as stiff", "-",
                 std::log10(soft / stiff) / 3, 1,
                 {0.05, "first order; the softest are not in its range, by a tenth"});
}

TEST(BendingSleepers, AHalfEqualsAWholeOne) {
  TrackParameters whole = bending(8, BeamTheory::timoshenko);
  whole.sleeper.unsupported = 0.6;
  TrackParameters half = whole;
  half.dimension = Dimension::plane;
  Coach one(whole, 2e-4, Dip::both), other(half, 2e-4, Dip::both);
  double wheel = 0, moment = 0;
  for (int i = 0; i < 400; ++i) {
    one.passage.advance(), other.passage.advance();
    for (std::size_t axle = 0; axle < 4; ++axle)
      wheel = std::max(
          wheel, std::abs(one.passage.wheel_force(2 * axle + 1) - other.passage.wheel_force(axle)));
    for (const double y : {0.0, 0.75}) {
      const double there = one.line.sleeper_moment(35, y, one.passage.line_motion().displacement);
      moment =
          std::max(moment, std::abs(there - other.line.sleeper_moment(
                                                35, y, other.passage.line_motion().displacement)));
    }
  }
  verified::below("largest difference of a wheel force", "N", wheel, contacts);
  verified::below("largest difference of a moment", "N m", moment,
                  {4e-3, "contacts converge to 1.3 mN, on levers of 0.75 m, four times"});
}

// N m, under a sine on one rail, after the decay of the transient.
std::vector<double> moments(double step) {
  LineParameters p;
  p.track = bending(8, BeamTheory::timoshenko);
  p.track.length = 24;
  const Line line(p);
  const TrainParameters none{.vehicles = {}, .speed = 1, .start = 0};
  const Train train(none, {}, 2, p.track.gauge);
  RailForce sine;
  sine.at = 12, sine.size = 10e3, sine.frequency = 150, sine.rise = 0.05;
  Passage passage(line, train, WheelRail({}), Irregularity({}, 24), none,
                  {.step = step, .duration = 0.1, .forces = {sine}});
  const auto every = std::lround(4e-4 / step);
  std::vector<double> found;
  for (int i = 1; i <= std::lround(0.1 / step); ++i) {
    passage.advance();
    if (i % every == 0)
      found.push_back(line.sleeper_moment(20, 0.75, passage.line_motion().displacement));
  }
  return found;
}

TEST(BendingSleepers, AreOfSecondOrderInTheStep) {
  const auto distance = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
  };
  const auto a = moments(2e-4), b = moments(1e-4), c = moments(5e-5);
  verified::above("largest moment below a rail", "N m", *std::max_element(a.begin(), a.end()),
                  {100, "separates: the sleeper bends"});
  verified::near("order from steps of 0.2, 0.1, 0.05 ms, moment below a rail", "-",
                 std::log2(distance(a, b) / distance(b, c)), 2,
                 {0.1, "second order; next term (omega dt)^2 = 0.036 at the coarsest"});
}

// Compressed over its whole length, a sleeper with a very small gap equals one without a gap: the
// stops at two points of each element are equivalent to the distributed ballast.
TEST(BendingSleepers, WithAGap) {
  const auto run = [](std::int64_t elements, double gap) {
    TrackParameters t = bending(elements);
    t.zones = {{.from = 17.9, .to = 18.1, .gap = gap}};
    Coach one(t, 2e-4);
    return one.line.sleeper_at(30, 0.75).deflection(one.passage.line_motion().displacement);
  };
  const double even = run(6, 0), touching = run(6, 1e-12), hanging = run(6, 1e-3);
  const verified::Tolerance points{
      4e-5, "two points of an element instead of its length: (b h)^4 / 720 = 1e-5, four times"};
  verified::near("below a coach, a gap of 0", "m", touching, even, points.of(even));
  verified::below("a gap of 1 mm", "m", hanging,
                  {1.1 * even, "separates: without ballast it is lower by a tenth or more"});
}

const verified::Tolerance equilibrium{
    1e-5, "rounding: 1e-16 of 2e10 N/m times 1 mm in each of 500 rows: 1e-6 N at most, ten times"};
const verified::Tolerance linear{
    1e-13, "linear: rounding of 1 mm times the condition, 1e5, 1e-14 m, ten times"};

// Moved ground below the ballast: the sum of forces on it is the load of the rails, and a uniform
// lift of the ground lifts the track equally.
TEST(BendingSleepers, OnMovedGround) {
  LineParameters p;
  p.track = bending(8, BeamTheory::timoshenko);
  p.track.dimension = Dimension::plane;
  p.track.length = 6, p.track.run_in = 0, p.track.ends = RailEnds::free;
  p.track.sleeper.unsupported = 0.5;
  p.first_moved = 0, p.moved = 11, p.moves = MovedPart::ground;
  const Line line(p);
  const std::vector<Seat> up(11, {.height = 1e-3, .rate = 0});
  Vector load = Vector::Zero(line.system().mass.rows());
  line.at(3.1).add(-100e3, load);
  line.add_seats(up, load);
  const Vector u = Statics(line.system()).flexibility(load), rest = Vector::Zero(u.size());
  double sum = 0;
  for (std::size_t i = 0; i < 11; ++i) sum += line.ground_force(i, u, rest, up[i]);
  verified::near("sum of forces on the ground", "N", sum, 100e3, equilibrium);
  load.setZero();
  line.add_seats(up, load);
  const Vector lifted = Statics(line.system()).flexibility(load);
  for (const double y : {0.0, 0.75, 1.25})
    verified::near(fmt::format("sleeper at {:g} m, ground lifted by 1 mm", y), "m",
                   line.sleeper_at(5, y).deflection(lifted), 1e-3, linear);
}

// Two rails, ballast less than half as stiff on the left, load on the left rail: force and moment
// are those of the load, and the track follows a rotation of the ground.
TEST(BendingSleepers, OnRotatedGround) {
  LineParameters p;
  p.track = bending(8, BeamTheory::timoshenko);
  p.track.length = 6, p.track.run_in = 0, p.track.ends = RailEnds::free;
  p.track.sleeper.unsupported = 0.5;
  p.track.zones = {{.from = -1, .to = 7, .bed = 0.4, .side = ZoneSide::left}};
  p.first_moved = 0, p.moved = 11, p.moves = MovedPart::ground;
  const Line line(p);
  const double arm = p.track.bearing_arm();
  const std::array<Seat, 2> rotated{Seat{.height = 1e-3, .rate = 0}, {.height = -5e-4, .rate = 0}};
  std::vector<Seat> seats;
  for (std::size_t i = 0; i < 11; ++i) seats.insert(seats.end(), rotated.begin(), rotated.end());
  Vector load = Vector::Zero(line.system().mass.rows());
  line.at(3.1, 0).add(-100e3, load);
  line.add_seats(seats, load);
  const Vector u = Statics(line.system()).flexibility(load), rest = Vector::Zero(u.size());
  double sum = 0, moment = 0;
  for (std::size_t i = 0; i < 11; ++i)
    for (const std::size_t side : {0, 1}) {
      const double force = line.ground_force(i, u, rest, rotated[side], side);
      sum += force, moment += force * (side == 0 ? arm : -arm);
    }
  verified::near("sum of forces on the ground, left rail loaded", "N", sum, 100e3, equilibrium);
  verified::near("their moment about the track's middle", "N m", moment, 75e3, equilibrium);
  load.setZero();
  line.add_seats(seats, load);
  const Vector lifted = Statics(line.system()).flexibility(load);
  for (const double y : {-1.25, 0.0, 0.75})
    verified::near(fmt::format("sleeper at {:g} m on rotated ground", y), "m",
                   line.sleeper_at(5, y).deflection(lifted), 2.5e-4 + 7.5e-4 * y / arm, linear);
}

}  // namespace
}  // namespace trackbed::track::bending_sleepers_test
