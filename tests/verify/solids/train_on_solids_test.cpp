// A train over solid sleepers on springs, compared with the track alone, which has rigid sleepers
// in its matrix, and with any length of step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/verified.hpp"
#include "trackbed/fem/bodies.hpp"
#include "trackbed/track/on_bed.hpp"

namespace trackbed::fem::train_on_solids_test {
namespace {

constexpr std::size_t before = 12, count = 17, watched = 8;  // sleepers of the bed; its middle one
constexpr double duration = 0.22, every = 4e-4;              // s; the second axle reaches the bed
constexpr double width = 0.29, height = 0.22;                // m

track::LineParameters track_of() {
  track::LineParameters p;
  p.track.length = 24;
  return p;
}

const track::TrainParameters motion{.vehicles = {"manchester_1"}, .speed = 50, .start = 0};

// Every 0.4 ms: N, of the first wheel; m, of the sleeper in the middle of the bed.
struct Histories {
  std::vector<double> wheel, sleeper;
};

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Histories alone(double dt) {
  const track::Line line(track_of());
  const track::Train train(motion, {}, 2);
  track::Passage passage(line, train, track::WheelRail({}), track::Irregularity({}, 24), motion,
                         {.step = dt});
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

struct Case {
  double dt;                        // s
  double stiffer = 1e4;             // Young's modulus over that of concrete
  double alpha = 0;                 // of Bossak's scheme
  double rails = 1;                 // of a sleeper
  std::vector<double> seats = {0};  // m, y from its middle
  track::LineParameters line = track_of();
  std::vector<std::string> vehicles = motion.vehicles;
};

// Sleepers with `rails` times the mass below one rail, on `rails` times its ballast spring,
// supported by fixed blocks; sleeper i on block count + i.
BodiesParameters solids(const Case& c) {
  const track::TrackParameters& track = c.line.track;
  const double length = 0.65 * c.rails,
               density = c.rails * track.sleeper_mass / 2 / (width * height * length);
  BodiesParameters p;
  p.alpha = c.alpha;
  for (const bool base : {false, true})
    for (std::size_t i = 0; i < count; ++i) {
      const double x = static_cast<double>(i) * track.spacing, z = base ? -height : 0;
      p.bodies.push_back({.name = "sleeper",
                          .low = {x - width / 2, -length / 2, z},
                          .high = {x + width / 2, length / 2, z + height},
                          .elements = {1, base ? 1 : 4, 1},
                          .solid = {.young = c.stiffer * 37e9, .poisson = 0, .density = density},
                          .touched = !base});
    }
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) * track.spacing;
    const Vec3 directions(1, 1, c.rails);
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

// Coupled as in model::SolidSleepers and model::StageTrain.
struct OnSolids {
  explicit OnSolids(const Case& given) : c(given), bodies(solids(c)), train(train_of()) {
    bodies.place(Vec3::Zero());
  }

  track::TrainOnBed train_of() {
    std::vector<track::Matrix2> mobility(count, track::Matrix2::Zero());
    for (std::size_t i = 0; i < count; ++i) {
      NodeWeights all;
      for (const double y : c.seats) {
        const double x = static_cast<double>(i) * c.line.track.spacing;
        for (const NodeWeight& one :
             bodies.over(i, Side::upper, {.x = {x - 0.07, x + 0.07}, .y = {y - 0.07, y + 0.07}}))
          all.push_back({one.node, one.weight / static_cast<double>(c.seats.size())});
      }
      seats.push_back(all);
      mobility[i](0, 0) = bodies.mobility(c.dt, all);
    }
    track::TrainParameters sent = motion;
    sent.vehicles = c.vehicles;
    return track::TrainOnBed({.line = c.line,
                              .vehicles = {},
                              .train = sent,
                              .wheel_rail = {},
                              .irregularity = {},
                              .seat = {.before = before, .rails = c.rails},
                              .sleepers = count,
                              .first = 0.6,
                              .step = c.dt,
                              .mobility = mobility},
                             std::vector<double>(count, 0.0));
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
    for (std::size_t i = 0; i < count; ++i)
      pushes.push_back({seats[i], {0, 0, -train.seat_force(i)}});
    bodies.add_loads(pushes);
  }

  // N, residual of the law of the pad of sleeper i for the present state of rail and seat.
  double off_law(std::size_t i) const {
    const track::Newmark& rail = train.passage().line_motion();
    const track::RailPoint at = train.line().at(train.line().sleeper_x(before + i));
    const double compression =
                     bodies.trapezoidal(c.dt, seats[i]).z() - at.deflection(rail.displacement),
                 rate = bodies.velocity(seats[i]).z() - at.deflection(rail.velocity);
    return train.seat_force(i) -
           c.rails * (c.line.pad.stiffness * compression + c.line.pad.damping * rate);
  }

  Case c;
  Bodies bodies;
  std::vector<NodeWeights> seats;
  track::TrainOnBed train;
};

Histories on_solids(const Case& c) {
  OnSolids model(c);
  Histories found;
  for (int i = 1; i <= std::lround(duration / c.dt); ++i) {
    model.window();
    if (i % std::lround(every / c.dt) != 0) continue;
    found.wheel.push_back(model.train.passage().wheel_force(0));
    found.sleeper.push_back(model.bodies.motion(watched).displacement.z());
  }
  return found;
}

// With alpha = 0 Bossak's scheme is the trapezoidal rule, as used by the track alone: the step is
// then the same, and the remaining difference is the deformation of the stiff sleepers.
TEST(TrainOnSolids, StiffSleepersEqualThoseOfTheTrackAlone) {
  const Histories rigid = alone(2e-4);
  const Histories stiff = on_solids({.dt = 2e-4}), soft = on_solids({.dt = 2e-4, .stiffer = 1e2});
  verified::below("wheel force with 1e4 E against rigid sleepers, root mean square", "N",
                  distance(stiff.wheel, rigid.wheel),
                  {5e-3, "contacts converge to 1e-12 m: 1.3 mN, four times"});
  verified::below("height of a sleeper with 1e4 E against a rigid one", "m",
                  distance(stiff.sleeper, rigid.sleeper),
                  {1e-10, "deformation: F l^3 / 400 E I = 1 um with E, 1e-4 of it"});
  verified::near("height difference with 1e4 E over that with 1e2 E", "-",
                 distance(stiff.sleeper, rigid.sleeper) / distance(soft.sleeper, rigid.sleeper),
                 1e-2, {2e-3, "first order in 1/E; contacts converge to 1e-12 of 8e-12 m: 1.3e-3"});
}

// Compared with the same steps of the track alone: the remaining difference is that of the two
// schemes.
TEST(TrainOnSolids, ConvergesToTheTrackAlone) {
  const Histories coarse = alone(2e-4), fine = alone(1e-4);
  const Case bossak{.dt = 2e-4, .stiffer = 1e6, .alpha = -0.1};
  Case shorter = bossak;
  shorter.dt = 1e-4;
  Case longer = bossak;
  longer.dt = 4e-4;
  const Histories coarsest = alone(4e-4), start = on_solids(longer);
  const Histories a = on_solids(bossak), b = on_solids(shorter);
  const verified::Tolerance order{0.1, "second order for any alpha; third: alpha (omega dt)^2 / 2"};
  const verified::Tolerance coarser{0.3, "second order for any alpha; windows twice as long"};
  const auto check = [&](const std::string& of, auto member) {
    const double first = distance(start.*member, coarsest.*member),
                 second = distance(a.*member, coarse.*member),
                 third = distance(b.*member, fine.*member);
    verified::near("order in the window, " + of, "-", std::log2(second / third), 2, order);
    verified::near("order from windows of 0.4 to 0.2 ms, " + of, "-", std::log2(first / second), 2,
                   coarser);
  };
  check("sleeper", &Histories::sleeper);
  check("wheel force", &Histories::wheel);
  verified::below("sleeper against the track alone, windows of 0.1 ms, root mean square", "m",
                  distance(b.sleeper, fine.sleeper),
                  {3e-10, "guards the factor beside the order: 9e-11 m, three times"});
  verified::below("wheel force against the track alone", "N", distance(b.wheel, fine.wheel),
                  {0.5, "guards the factor beside the order: 0.18 N, three times"});
}

// Softer pads by a zone over the whole track equal softer pads everywhere, to rounding.
TEST(TrainOnSolids, AZoneOfSofterPadsEqualsSofterPads) {
  Case zoned{.dt = 4e-4}, everywhere = zoned, none = zoned;
  zoned.line.track.zones = {{.from = 0, .to = 24, .pad = 0.5}};
  everywhere.line.pad.stiffness *= 0.5;
  everywhere.line.pad.damping *= 0.5;
  const Histories one = on_solids(zoned), other = on_solids(everywhere);
  verified::below("wheel force, zone of half the pad stiffness against half of it everywhere", "N",
                  distance(one.wheel, other.wheel), {1e-3, "contacts converge to 1e-12 m: 1 mN"});
  EXPECT_GT(distance(one.wheel, on_solids(none).wheel), 10);
}

// Whole sleepers with two seats carry both rails; their middle does not bend if each seat is at the
// middle of the spring forces of its half, and with 1e4 E the remaining deformation is negligible.
TEST(TrainOnSolids, AWholeTrackEqualsTwoHalves) {
  const Histories half = on_solids({.dt = 2e-4});
  const Histories whole = on_solids({.dt = 2e-4, .rails = 2, .seats = {-0.325, 0.325}});
  verified::below("wheel force, whole sleepers against halves", "N",
                  distance(half.wheel, whole.wheel), {1e-3, "contacts converge to 1e-12 m: 1 mN"});
  verified::below(
      "height of a sleeper, whole against half", "m", distance(half.sleeper, whole.sleeper),
      {1e-11, "deformation with 1e4 E, 8e-12 m, of which halves and wholes differ in part"});
}

TEST(TrainOnSolids, ThePadForceIsThatAtTheEndOfTheWindow) {
  OnSolids model({.dt = 2e-4, .stiffer = 1, .alpha = -0.1});
  double off = 0, largest = 0;
  for (int n = 0; n < 1000; ++n) {
    model.window();
    for (std::size_t i = 0; i < count; ++i) {
      off = std::max(off, std::abs(model.off_law(i)));
      largest = std::max(largest, std::abs(model.train.seat_force(i)));
    }
  }
  EXPECT_GT(largest, 1e4);
  EXPECT_LT(off, 1e-9 * largest);
}

// Explicit sleepers of 1.5 kg on these pads are stable up to 0.22 ms without the dashpots and 0.06
// ms with them. Here no window generates energy: after an impulse the sleepers come to rest, or
// without dashpots their amplitude does not grow.
TEST(TrainOnSolids, AnyWindowIsStable) {
  for (const double alpha : {0.0, -0.1, -1.0 / 3})
    for (const double dt : {1e-4, 1e-2, 1.0})
      for (const bool damped : {true, false}) {
        Case c{.dt = dt, .stiffer = 1, .alpha = alpha};
        c.vehicles = {};
        c.line.track.sleeper_mass = 3;
        if (!damped) c.line.pad.damping = c.line.ballast.damping = 0;
        OnSolids model(c);
        const Bodies::PatchLoad blow{model.seats[watched], {0, 0, -1e5}};
        model.window(std::span(&blow, 1));
        double early = 0, late = 0;
        constexpr int windows = 1000;
        for (int n = 0; n < windows; ++n) {
          model.window();
          const double found = std::abs(model.bodies.displacement(model.seats[watched]).z());
          (n < windows / 2 ? early : late) = std::max(n < windows / 2 ? early : late, found);
        }
        EXPECT_LE(late, early) << "alpha " << alpha << ", dt " << dt << ", damped " << damped;
      }
}

// A free bar on a stiff spring and dashpot below a mass with trapezoidal steps: with `displacement`
// instead of `trapezoidal` below the spring the amplitude grows by 0.3 % in each step.
TEST(TrainOnSolids, TheTrapezoidalSeatGeneratesNoEnergy) {
  const auto largest_after = [](bool trapezoidal) {
    BodiesParameters p;
    constexpr double unit = 1e-3, dt = 1;  // kg, s
    p.bodies = {{.name = "bar",
                 .high = {1, 1, 1},
                 .solid = {.young = 1, .poisson = 0, .density = 1.684 * unit}},
                {.name = "base", .low = {0, 0, -1}, .high = {1, 1, 0}, .solid = {.young = 1}}};
    p.pads = {{.below = 1, .above = 0, .patch = {.x = {0, 1}, .y = {0, 1}}}};
    p.pads[0].stiffness = {1, 1, 15401 * unit};
    for (const bool low : {true, false})
      p.held.push_back({.body = 1, .axis = 0, .low = low, .components = {true, true, true}});
    p.bodies[0].solid.young = 1e9;
    Bodies bodies(p);
    bodies.place(Vec3::Zero());
    const NodeWeights seat = bodies.over(0, Side::upper, {.x = {0, 1}, .y = {0, 1}});
    const double stiffness = 2442, damping = 219.6, mass = 735.5 * unit;
    const double y = bodies.mobility(dt, seat);
    const double compliance = trapezoidal ? y * dt / 2 : y * dt * 0.3025 / 0.6;
    double u = 0, v = 0, a = 0, largest = 0;
    for (int n = 0; n < 4000; ++n) {
      const Bodies::PatchLoad first{seat, {0, 0, n == 0 ? 1.0 : 0.0}};
      bodies.advance(dt, 0, std::span(&first, 1), {});
      const double level =
          (trapezoidal ? bodies.trapezoidal(dt, seat) : bodies.displacement(seat)).z();
      // The force at the end of the step acts on both; of the unknowns F, u and v at the end, F is
      // solved for.
      const double u0 = u + dt * v + dt * dt / 4 * a, v0 = v + dt / 2 * a;
      const double force =
          (stiffness * (level - u0) + damping * (bodies.velocity(seat).z() - v0)) /
          (1 + stiffness * (compliance + dt * dt / 4 / mass) + damping * (y + dt / 2 / mass));
      const Bodies::PatchLoad pad{seat, {0, 0, -force}};
      bodies.add_loads(std::span(&pad, 1));
      a = force / mass, u = u0 + dt * dt / 4 * a, v = v0 + dt / 2 * a;
      if (n >= 2000) largest = std::max(largest, std::abs(v));
    }
    return largest;
  };
  EXPECT_LT(largest_after(true), 10);
  EXPECT_GT(largest_after(false), 1e3);
}

}  // namespace
}  // namespace trackbed::fem::train_on_solids_test
