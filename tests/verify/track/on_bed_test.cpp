// A train over moved sleepers, against the track alone with these sleepers in its matrix: they are
// on springs, so that both are the same track.
#include "trackbed/track/on_bed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/verified.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::track::on_bed_test {
namespace {

constexpr std::size_t before = 12, count = 17, watched = 8;  // sleepers of the bed; its middle one
constexpr double duration = 0.22, every = 4e-4;              // s; the second axle is on the bed

LineParameters track_of(double bilinear_at = 0, const std::vector<TrackZone>& zones = {}) {
  LineParameters p;
  p.track.zones = zones;
  p.track.length = 24;
  p.pad.bilinear_at = bilinear_at;
  p.pad.bilinear_stiffness = 4 * p.pad.stiffness;
  return p;
}

const TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 0};

// Every 0.4 ms: N, of the first wheel; m, of the sleeper in the middle of the bed.
struct Histories {
  std::vector<double> wheel, sleeper;
};

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Histories alone(double dt, double bilinear_at = 0) {
  const Line line(track_of(bilinear_at));
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 24), motion, {.step = dt});
  const std::int32_t unknown = line.sleeper_unknown(before + watched);
  Histories found;
  for (int i = 1; i <= std::lround(duration / dt); ++i) {
    passage.advance();
    if (i % std::lround(every / dt) != 0) continue;
    found.wheel.push_back(passage.wheel_force(0));
    found.sleeper.push_back(passage.line_motion().displacement[unknown]);
  }
  return found;
}

// now: spring forces at the time of the pad forces. late: their mean over the last window, like the
// forces of stones.
enum class Springs { now, late };

struct OnBed {
  OnBed(double dt, double rails, Springs how, double bilinear_at = 0,
        const std::vector<TrackZone>& zones = {})
      : step(dt),
        springs(how),
        line(track_of(bilinear_at, zones)),
        sleepers({.count = count,
                  .first = 0.6,
                  .length = 1,
                  .density = rails * line.track.sleeper_mass / 2 / (0.29 * 0.22),
                  .free = {"z"}},
                 Dimension::plane, 1, 0),
        train({.line = line,
               .vehicles = {},
               .train = motion,
               .wheel_rail = {},
               .irregularity = {},
               .seat = {.before = before, .rails = rails},
               .sleepers = count,
               .first = 0.6,
               .step = dt},
              std::vector<double>(count, 0.0)),
        bed(rails),
        last(count, 0.0) {
    sleepers.place(1);
  }

  // As Simulation::move_sleepers.
  void window() {
    std::vector<double> seats, levels, rates;
    std::vector<std::vector<Vec3>> nodes;
    for (std::size_t i = 0; i < count; ++i) {
      seats.push_back(train.seat_force(i));
      const double now = -bed * (line.ballast.stiffness * sleepers.state(i).displacement.z() +
                                 line.ballast.damping * sleepers.velocity_now(i).z());
      const double force = springs == Springs::now ? now : (now + last[i]) / 2;
      last[i] = now;
      const std::size_t n = sleepers.surfaces()[i].nodes();
      nodes.emplace_back(n, Vec3(0, 0, force / static_cast<double>(n)));
    }
    sleepers.advance(step, seats, {nodes.begin(), nodes.end()}, 0);
    for (std::size_t i = 0; i < count; ++i) {
      levels.push_back(sleepers.state(i).displacement.z());
      rates.push_back(sleepers.velocity_now(i).z());
    }
    train.advance(levels, rates);
  }

  double step;
  Springs springs;
  LineParameters line;
  RigidSleepers sleepers;
  TrainOnBed train;
  double bed;                // spring stiffness below a sleeper over that of one rail
  std::vector<double> last;  // N, of the springs a window ago
};

Histories on_bed(double dt, double rails = 1, Springs how = Springs::now, double bilinear_at = 0) {
  OnBed model(dt, rails, how, bilinear_at);
  Histories found;
  for (int i = 1; i <= std::lround(duration / dt); ++i) {
    model.window();
    if (i % std::lround(every / dt) != 0) continue;
    found.wheel.push_back(model.train.passage().wheel_force(0));
    found.sleeper.push_back(model.sleepers.state(watched).displacement.z());
  }
  return found;
}

// Equal steps on both sides, so that the difference is the error of the exchange only; the error of
// the steps themselves, of order 1.4 here since the wheels pass from one element to the next, is
// equal to that of the track alone.
TEST(TrainOnBed, ConvergesToTheTrackAlone) {
  const Histories exact = alone(1.25e-5), coarsest = alone(2e-4), coarse = alone(1e-4),
                  fine = alone(5e-5);
  const Histories start = on_bed(2e-4), a = on_bed(1e-4), b = on_bed(5e-5);
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
  check("sleeper", &Histories::sleeper);
  check("wheel force", &Histories::wheel);
  verified::below("sleeper against the track alone, windows of 0.05 ms, root mean square", "m",
                  distance(b.sleeper, fine.sleeper),
                  {2e-10, "guards the factor beside the order: 1.4e-10"});
  verified::below("wheel force against the track alone", "N", distance(b.wheel, fine.wheel),
                  {0.4, "guards the factor beside the order: 0.27 N"});
  verified::near("error of the wheel force over that of the track alone", "-",
                 distance(b.wheel, exact.wheel) / distance(fine.wheel, exact.wheel), 1,
                 {0.05, "the exchange adds less than a twentieth to the error of the steps"});
}

// Forces of stones are the means over the last window.
TEST(TrainOnBed, ADelayedReactionIsOfFirstOrder) {
  const Histories coarse = alone(1e-4), fine = alone(5e-5);
  const Histories a = on_bed(1e-4, 1, Springs::late), b = on_bed(5e-5, 1, Springs::late);
  const double error = distance(b.sleeper, fine.sleeper);
  const verified::Tolerance first{0.05,
                                  "first order; next term half a window times 2 pi 200 Hz: 0.06"};
  verified::near("order in the window, sleeper", "-",
                 std::log2(distance(a.sleeper, coarse.sleeper) / error), 1, first);
  const Histories coarsest = alone(2e-4), start = on_bed(2e-4, 1, Springs::late);
  verified::near(
      "order from windows of 0.2 to 0.1 ms, sleeper", "-",
      std::log2(distance(start.sleeper, coarsest.sleeper) / distance(a.sleeper, coarse.sleeper)), 1,
      {0.1, "first order; next term half a window times 2 pi 200 Hz: 0.13"});
  verified::below("sleeper against the track alone, windows of 0.05 ms, root mean square", "m",
                  error, {1e-7, "guards the factor beside the order: 5e-8, twice"});
}

// Bilinear pads are contacts of the rail's solve, also on sleepers of the bed.
TEST(TrainOnBed, BilinearPads) {
  constexpr double bilinear_at = 1e-4;  // m: exceeded under every wheel
  const Histories linear = alone(5e-5), exact = alone(2.5e-5, bilinear_at);
  const Histories bilinear = on_bed(5e-5, 1, Springs::now, bilinear_at);
  const double error = distance(bilinear.sleeper, exact.sleeper);
  verified::below("error of a sleeper over the effect of bilinear pads", "-",
                  error / distance(linear.sleeper, exact.sleeper),
                  {2e-3, "steps of 50 us: (omega dt)^2 / 12 = 7e-4 at 300 Hz, three times"});
}

// Twice the mass on twice the springs under two rails: a factor of two is exact in every number.
TEST(TrainOnBed, AWholeTrackIsTwoHalves) {
  const Histories half = on_bed(2e-4, 1), whole = on_bed(2e-4, 2);
  EXPECT_EQ(half.sleeper, whole.sleeper);
  EXPECT_EQ(half.wheel, whole.wheel);
}

TEST(TrainOnBed, IsRestarted) {
  OnBed model(2e-4, 1, Springs::now);
  const double force = model.train.passage().wheel_force(0), x = model.train.wheel_x(0);
  // The frame of the track follows from its sleepers: the first of the bed is at 0.6 m.
  EXPECT_NEAR(x, 0.6 - before * 0.6, 1e-12);
  for (int i = 0; i < 1000; ++i) model.window();
  const double lowest = model.train.rail_displacement(0);
  EXPECT_NEAR(model.train.wheel_x(0), x + 10, 1e-9);
  model.train.restart_train();
  EXPECT_EQ(model.train.wheel_x(0), x);
  EXPECT_EQ(model.train.passage().wheel_force(0), force);
  EXPECT_EQ(model.train.rail_displacement(0), lowest);  // the state of the rail is kept
  for (int i = 0; i < 1000; ++i) model.window();
  EXPECT_NEAR(model.train.wheel_x(0), x + 10, 1e-9);
}

// A rail that is laid higher than a sleeper lies lifts it.
TEST(TrainOnBed, TheRailLiftsAHangingSleeper) {
  constexpr double gap = 5e-4;  // m
  TrackZone zone{.from = 0.6 * (before + watched) - 0.3, .to = 0.6 * (before + watched) + 0.3};
  zone.gap = gap;
  OnBed plain(2e-4, 1, Springs::now), hanging(2e-4, 1, Springs::now, 0, {zone});
  double bed = 0;  // N, of the springs below all sleepers
  for (int i = 0; i < 500; ++i) hanging.window(), plain.window();
  for (std::size_t i = 0; i < count; ++i)
    bed -= hanging.line.ballast.stiffness *
           (hanging.sleepers.state(i).displacement.z() - plain.sleepers.state(i).displacement.z());
  const double lifted = hanging.sleepers.state(watched).displacement.z() -
                        plain.sleepers.state(watched).displacement.z();
  EXPECT_GT(lifted, 0);
  EXPECT_LT(lifted, gap);
  const double force = hanging.train.seat_force(watched) - plain.train.seat_force(watched);
  EXPECT_NEAR(force, -hanging.line.ballast.stiffness * lifted, 1e-3 * std::abs(force));
  // Springs beyond the bed carry the rest.
  EXPECT_NEAR(bed, 0, 0.02 * std::abs(force));
}

TrainOnBed over(const LineParameters& line, const std::vector<double>& levels,
                const std::vector<double>& kept) {
  return {{.line = line,
           .vehicles = {},
           .train = motion,
           .wheel_rail = {},
           .irregularity = {},
           .seat = {.before = before, .rails = 1},
           .sleepers = count,
           .first = 0.6,
           .step = 2e-4,
           .kept = kept,
           .ramp = 0.02},
          levels};
}

// A sleeper has settled since the rail was laid: the pads of the kept rail have no force at first,
// and after the ramp the same as those of a rail that is laid with a gap above this sleeper.
TEST(TrainOnBed, AKeptRailLiftsASettledSleeper) {
  constexpr double settled = 5e-4;  // m
  TrackZone zone{.from = 0.6 * (before + watched) - 0.3, .to = 0.6 * (before + watched) + 0.3};
  zone.gap = settled;
  const LineParameters line = track_of(0, {}), with_gap = track_of(0, {zone});
  std::vector<double> levels(count, 0.01);
  const std::vector<double> before_it = levels;
  levels[watched] -= settled;
  TrainOnBed kept = over(line, levels, before_it), gap = over(with_gap, levels, {});
  EXPECT_EQ(kept.levels_without_load(), before_it);
  EXPECT_EQ(kept.seat_force(watched), 0);
  const std::vector<double> still(count, 0.0);
  const double stiff = line.pad.stiffness * settled;
  double largest = 0;  // N
  for (int k = 0; k < 500; ++k) {
    kept.advance(levels, still), gap.advance(levels, still);
    largest = std::max(largest, -kept.seat_force(watched));
  }
  EXPECT_LT(largest, 0.9 * stiff);  // gradually, and the rail bends
  for (std::size_t i = 0; i < count; ++i)
    EXPECT_NEAR(kept.seat_force(i), gap.seat_force(i), 1e-3 * stiff);
  EXPECT_LT(kept.seat_force(watched), -0.1 * stiff);
}

}  // namespace
}  // namespace trackbed::track::on_bed_test
