// Two rails on a ground of elements: under a symmetric load against the plane track, under a load
// on one rail against springs in series with a ground that both ends of a sleeper load; in motion
// the order, energy and balances.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support/verified.hpp"
#include "verify/ground/half_space.hpp"
#include "verify/track/on_ground_scene.hpp"

namespace trackbed::model::two_rails_on_ground_test {
namespace {

using par::Comm;
using track::Matrix2;

// Whole sleepers on a ground in space, the left rail loaded. Elements of 0.3 m.
Model wide(std::int64_t count, const fem::Elastic& soil = {60e6, 0.3, 2000}) {
  Model m = model_of(count, soil);
  m.dimension = m.track.line.track.dimension = Dimension::space;
  m.ground = fem::box({0.6 * static_cast<double>(count), 3.6, 1.2}, {2 * count, 12, 4}, soil);
  m.ground.base = fem::Base::fixed;
  m.ground.sides = fem::Sides::roller;
  m.footing.length = 2.6, m.footing.y = 1.8, m.footing.rails = 2;
  return m;
}

// Of both ends of a sleeper.
struct Ends {
  double left, right;
};

// All features together: impacts on both rails, hanging sleepers, bilinear pads. Weights of both
// ends add up to those of a uniform pressure, and on a symmetric ground the heights at both ends
// are equal. The remaining difference is rounding, since piecewise linear contacts are solved
// exactly.
TEST(TwoRailsOnGround, UnderASymmetricLoadAreThePlaneTrack) {
  Model space = wide(5);
  track::LineParameters& line = space.track.line;
  line.pad.bilinear_at = 2e-5, line.pad.bilinear_stiffness = 400e6;
  line.track.zones = {{.from = 4.7, .to = 6.1, .gap = 5e-5}};
  space.track.passage.step = 5e-5;
  Model plane = space;
  plane.track.line.track.dimension = Dimension::plane;
  space.track.passage.forces.push_back(space.track.passage.forces[0]);
  space.track.passage.forces[1].side = track::ForceSide::right;
  Pair both(space), one(plane);
  ASSERT_EQ(both.whole.below->step(), one.whole.below->step());
  double off = 0, ground = 0, force = 0, most = 0;
  for (int n = 0; n < 600; ++n) {
    both.step(), one.step();
    const track::Passage &two = both.built.passage, &single = one.built.passage;
    for (const std::size_t i : {before, before + 2, before + 4})
      for (const std::size_t side : {0, 1}) {
        off = std::max(off, std::abs(sleeper(both, i, side) - sleeper(one, i)));
        ground = std::max(
            ground, std::abs(two.ground_below(i, side).height - single.ground_below(i).height));
        force = std::max(force, std::abs(two.ground_force(i, side) - single.ground_force(i)));
        most = std::max(most, std::abs(sleeper(one, i)));
      }
  }
  const verified::Limit rounding{2e-16, "rounding of 0.6 mm, 1e-19 m, in 600 steps: 6e-17 m"};
  verified::above("largest motion of a sleeper", "m", most, {1e-4, "separates: the track moves"});
  verified::below("largest difference of a sleeper", "m", off, rounding);
  verified::below("largest difference of the ground below it", "m", ground, rounding);
  verified::below("largest difference of the force on it", "N", force,
                  {1e-7, "rounding of sleepers, 2e-16 m, times 400 MN/m"});
}

// Load of a node at `at`, between elements of length `size`, due to p(y) on [from, to]: the
// integral of its hat function times p, by Simpson's rule on parts where both are smooth, exact for
// linear p.
template <class P>
double nodal_load(double at, double size, double from, double to, const P& p) {
  double sum = 0;
  for (const double begin : {at - size, at}) {
    const double a = std::max(begin, from), b = std::min(begin + size, to);
    if (b <= a) continue;
    const auto f = [&](double y) { return (1 - std::abs(y - at) / size) * p(y); };
    sum += (b - a) / 6 * (f(a) + 4 * f((a + b) / 2) + f(b));
  }
  return sum;
}

// m/N, static mean heights of a footprint on the top of a ground due to each of two pressures of 1
// N in sum; left, right: pressure over its mean, as functions of y from the middle of the
// footprint.
template <class Left, class Right>
Matrix2 flexibility(const Model& m, const Left& left, const Right& right) {
  const double size = 0.3, x = m.footing.first, w = m.footing.width / 2;
  const double y = m.footing.y, half = m.footing.length / 2;
  fem::Ground ground(Comm::world(), fem::half_space(m.ground), Dimension::space, 1);
  const std::vector<Vec3> home = ground.top().position;
  const auto weight = [&](std::size_t n, std::size_t side) {
    const auto p = [&](double at) { return side == 0 ? left(at - y) : right(at - y); };
    return nodal_load(home[n].x(), size, x - w, x + w, [](double) { return 1.0; }) *
           nodal_load(home[n].y(), size, y - half, y + half, p) / (4 * w * half);
  };
  Matrix2 result;
  for (const std::size_t loaded : {0, 1}) {
    fem::Ground fresh(Comm::world(), fem::half_space(m.ground), Dimension::space, 1);
    std::vector<Vec3> load(home.size(), Vec3::Zero());
    for (std::size_t n = 0; n < home.size(); ++n) load[n].z() = -1e5 * weight(n, loaded);
    fem::load_statically(fresh, load);
    std::array<double, 2> down{};
    for (const auto node : fresh.own_top())
      for (const std::size_t side : {0, 1})
        down[side] -= weight(static_cast<std::size_t>(node), side) *
                      fresh.top_motion(node).displacement.z() / 1e5;
    Comm::world().sum(std::span<double>(down));
    for (const std::size_t side : {0, 1})
      result(static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(loaded)) = down[side];
  }
  return result;
}

// m, heights of the sleeper below its rails under these seat forces: springs at +-arm, with an
// additional compliance of `under` m/N, on a ground with this flexibility.
Ends in_series(const Model& m, const Ends& seats, double arm, const Matrix2& ground, double under) {
  const double sum = seats.left + seats.right, gauge = m.track.line.track.gauge;
  const double difference = gauge / 2 * (seats.left - seats.right) / arm;
  const Eigen::Vector2d force((sum + difference) / 2, (sum - difference) / 2);
  const double spring = 1 / m.track.line.ballast.stiffness + under;
  Eigen::Vector2d compliance(spring, spring);
  for (const track::TrackZone& zone : m.track.line.track.zones)
    compliance[0] += (1 / zone.bed - 1) / m.track.line.ballast.stiffness;
  const Eigen::Vector2d height = -(compliance.cwiseProduct(force) + ground * force);
  const double mean = (height[0] + height[1]) / 2, turn = (height[0] - height[1]) / (2 * arm);
  return {mean + turn * gauge / 2, mean - turn * gauge / 2};
}

// One sleeper on a soft block with different sides, ballast half as stiff on the left, the left
// rail loaded. The footprint cuts elements, is longer than the sleeper by `beyond`, and is not in
// the middle of the ground.
void check_roll(double beyond, double under) {
  Model m = wide(1);
  m.ground = fem::box({2.4, 3.9, 1.2}, {8, 13, 4}, {60e6, 0.3, 2000});
  m.ground.base = fem::Base::fixed;
  m.ground.sides = fem::Sides::roller;
  m.footing.first = 1.1, m.footing.width = 0.5, m.footing.length = 2.6 + beyond;
  m.footing.y = 1.75;
  m.track.line.track.zones = {{.from = 4.1, .to = 4.3, .bed = 0.5, .side = track::ZoneSide::left}};
  if (under > 0) m.track.line.under_sleeper = {.stiffness = 1 / under, .damping = 10e3};
  Pair pair(at_rest(m));
  pair.run(1.0);
  const track::Newmark& motion = pair.built.passage.line_motion();
  const auto seat = [&](std::size_t side) {
    return pair.built.line.seat_force(before, motion.displacement, motion.velocity, {}, side);
  };
  const double length = m.footing.length, arm = 2.6 / std::sqrt(12.0);
  const double rise = 12 * arm / (length * length);
  const Matrix2 ground = flexibility(
      m, [&](double y) { return 1 + rise * y; }, [&](double y) { return 1 - rise * y; });
  const Ends expected = in_series(m, {seat(0), seat(1)}, arm, ground, under);
  const double left = sleeper(pair, before, 0), right = sleeper(pair, before, 1);
  const verified::Tolerance tolerance = almost_static.of(std::max(std::abs(left), std::abs(right)));
  verified::near("height below the left rail", "m", left, expected.left, tolerance);
  verified::near("height below the right rail", "m", right, expected.right, tolerance);
  verified::near("roll times the gauge", "m", left - right, expected.left - expected.right,
                 tolerance);
  if (beyond > 0) return;
  // Each spring on one half of the footprint, uniformly, at a quarter of the length: different.
  const Matrix2 halves = flexibility(
      m, [](double y) { return y > 0 ? 2.0 : 0.0; }, [](double y) { return y < 0 ? 2.0 : 0.0; });
  const Ends other = in_series(m, {seat(0), seat(1)}, length / 4, halves, under);
  verified::above("roll times the gauge, difference to two half footprints, over the tolerance",
                  "-", std::abs(left - right - other.left + other.right) / tolerance.size,
                  {30, "separates from two springs on half of the footprint each"});
}

TEST(TwoRailsOnGround, SpringsAndBlockInSeries) { check_roll(0, 0); }
TEST(TwoRailsOnGround, PadsSpringsAndBlockBelowALongerFootprint) { check_roll(0.5, 1 / 80e6); }

// Every 0.4 ms: m, of both ends of a sleeper and of the ground below them, under a growing force of
// 50 Hz on one rail.
using Histories = std::array<std::vector<double>, 4>;
Histories shaken(double step) {
  Model m = wide(3);
  auto& force = m.track.passage.forces[0];
  force.kind = track::ForceKind::harmonic, force.frequency = 50, force.rise = 0.02;
  m.track.passage.step = step;
  Pair pair(m);
  Histories found;
  for (int row = 0; row < 75; ++row) {
    pair.run(4e-4);
    for (const std::size_t side : {0, 1}) {
      found[side].push_back(sleeper(pair, before + 1, side));
      found[2 + side].push_back(pair.built.passage.ground_below(before + 1, side).height);
    }
  }
  return found;
}

TEST(TwoRailsOnGround, IsOfSecondOrder) {
  const Histories a = shaken(8e-5), b = shaken(4e-5), c = shaken(2e-5);
  const std::array of = {"sleeper, left", "sleeper, right", "ground, left", "ground, right"};
  for (std::size_t k = 0; k < of.size(); ++k) {
    verified::near(fmt::format("order in the step, {}", of[k]), "-",
                   std::log2(distance(a[k], b[k]) / distance(b[k], c[k])), 2, second_order);
    verified::below(
        fmt::format("change from steps of 0.04 to 0.02 ms, root mean square, {}", of[k]), "m",
        distance(b[k], c[k]),
        {2e-8, "(omega dt)^2 / 16 = 1e-5 of 0.5 mm at 50 Hz: 5e-9 m, four times"});
  }
}

// Impact on one rail, at the longest step that the program uses.
void check_energy(Model m) {
  m.track.line.ballast.damping = m.track.line.pad.damping = 0;
  Pair pair(m);
  pair.run(0.01);
  double begin = 0, end = 0, most = 0, roll = 0;
  constexpr int steps = 20000, part = 200;
  for (int n = 0; n < steps / part; ++n) {
    pair.run(part * pair.whole.below->step());
    const double energy = pair.energy();
    if (n < 10) begin += energy / 10;
    if (n >= steps / part - 10) end += energy / 10;
    most = std::max(most, energy);
    roll = std::max(roll, std::abs(sleeper(pair, before + 1, 0) - sleeper(pair, before + 1, 1)));
  }
  verified::above("largest difference of both ends of a sleeper", "m", roll,
                  {1e-6, "separates: the sleeper rolls"});
  verified::near("mean energy after 18000 steps over that of the first 2000", "-", end / begin, 1,
                 mean_energy);
  verified::below("largest energy over the first mean", "-", most / begin, largest_energy);
  const auto of = pair.whole.below->energies(pair.built.passage);
  const double held = of.ground.kinetic + of.ground.elastic;
  verified::near("energy of the ground over the work of the ballast on it", "-",
                 held / of.given_to_ground, 1, ground_energy);
  const auto balance = pair.whole.below->balance();
  for (const char* name : {"force", "moment", "roll_moment", "work"})
    verified::below(std::string("largest imbalance of ") + name, "-", balance[name].get<double>(),
                    rounding_of_sums);
}

TEST(TwoRailsOnGround, KeepsEnergyAtTheLongestStep) { check_energy(wide(3)); }

// Three springs in series below each end: the lowest is below the ballast mass.
TEST(TwoRailsOnGround, KeepsEnergyOfPadsAndBallastMasses) {
  Model m = wide(3);
  m.track.line.under_sleeper = {.stiffness = 80e6, .damping = 0};
  m.track.line.ballast.mass = 300, m.track.line.ballast.below_damping = 0;
  check_energy(m);
}

// Ballast half as stiff on the left, none below the middle.
Model bending(track::BeamTheory theory, double young) {
  Model m = wide(3);
  track::TrackParameters& track = m.track.line.track;
  track.zones = {{.from = -1, .to = 20, .bed = 0.5, .side = track::ZoneSide::left}};
  track.sleeper.model = track::SleeperModel::beam;
  track.sleeper.unsupported = 0.4, track.sleeper.theory = theory, track.sleeper.young = young;
  return m;
}

TEST(TwoRailsOnGround, KeepsEnergyOfBendingSleepers) {
  check_energy(bending(track::BeamTheory::timoshenko, 35e9));
}

// Thin bars have the roll inertia of rigid ones. Ballast is equal left and right: for different
// ballast the two springs of a rigid sleeper are only an approximation.
TEST(TwoRailsOnGround, StiffBendingSleepersEqualRigidOnes) {
  const auto differ = [](double young) {
    Model beam = bending(track::BeamTheory::euler, young);
    beam.track.line.track.zones = {};
    Model rigid = beam;
    rigid.track.line.track.sleeper.model = track::SleeperModel::rigid;
    for (Model* m : {&beam, &rigid}) m->track.passage.step = 1e-4;
    Pair one(beam), other(rigid);
    double off = 0, most = 0;
    for (int n = 0; n < 300; ++n) {
      one.step(), other.step();
      for (const std::size_t side : {0, 1}) {
        const double there = other.built.passage.ground_force(before + 1, side);
        most = std::max(most, std::abs(there));
        off = std::max(off, std::abs(one.built.passage.ground_force(before + 1, side) - there));
      }
    }
    return off / most;
  };
  const double soft = differ(35e9), stiff = differ(35e12), stiffer = differ(35e13);
  verified::above("largest difference of forces on the ground, as stiff as sleepers are", "-", soft,
                  {0.01, "separates: bending has an effect"});
  const verified::Limit flexible{
      2e-4, "first order in the flexibility: 1e-4 of the difference above, twice"};
  verified::below("ten thousand times as stiff", "-", stiffer, flexible.of(soft));
  verified::near("order in their flexibility", "-", std::log10(stiff / stiffer), 1,
                 {0.01, "first order; next term 1e-3, and rounding of 1e-6 of the force"});
  verified::near("order in their flexibility, 1 to 1000 times as stiff", "-",
                 std::log10(soft / stiff) / 3, 1,
                 {0.1, "first order; the softest are not in its range, by a tenth"});
}

// Gaps below the left ends of three sleepers at the impact; relative to the energy after it.
TEST(TwoRailsOnGround, KeepsEnergyOfHangingEnds) {
  Model m = wide(5);
  track::LineParameters& line = m.track.line;
  line.ballast.damping = line.pad.damping = 0;
  line.track.zones = {{.from = 4.7, .to = 6.1, .gap = 5e-5, .side = track::ZoneSide::left}};
  m.track.passage.step = 2e-5;
  Pair pair(m);
  pair.run(0.0101);
  const double after = pair.energy();
  double furthest = 0, in_stops = 0;
  for (int n = 0; n < 2500; ++n) {
    pair.step();
    const track::Passage& passage = pair.built.passage;
    furthest = std::max(furthest, std::abs(pair.energy() - after));
    in_stops = std::max(in_stops, passage.track_energy() - passage.line_motion().energy());
  }
  verified::above("largest fraction of the energy in closed gaps", "-", in_stops / after,
                  {0.02, "separates: gaps close"});
  verified::below("largest change of energy in 50 ms", "-", furthest / after, corners);
}

// Under a nearly constant load the damper forces of closed gaps must not oscillate, although the
// time integration of the ground differs from that of the track.
TEST(TwoRailsOnGround, ForcesOfHangingEndsDoNotOscillate) {
  Model m = at_rest(wide(3));
  m.track.line.track.zones = {{.from = 4.7, .to = 4.9, .gap = 1e-4, .side = track::ZoneSide::left}};
  Pair pair(m);
  pair.run(1);
  std::array<double, 3> last{};  // N, of the last steps
  double bend = 0, least = 1e300;
  for (int n = 0; n < 20; ++n) {
    pair.step();
    last = {last[1], last[2], pair.built.passage.ground_force(before + 1, 0)};
    if (n < 2) continue;
    bend = std::max(bend, std::abs(last[0] - 2 * last[1] + last[2]));
    least = std::min(least, last[0]);
  }
  verified::above("force of the hanging end", "N", least, {1e4, "separates: its gap is closed"});
  verified::below("second difference of the force, relative", "-", bend / least,
                  {2e-6, "the load, an impact of 2 s, has (pi h / 2 s)^2, up to 1e-6; twice"});
}

// A ground a million times as stiff and as heavy: two rails alone, except for its compliance.
TEST(TwoRailsOnGround, ARigidGroundEqualsTheTrackAlone) {
  Model m = wide(3, {60e12, 0.3, 2000e6});
  m.track.passage.step = 5e-5;
  Pair pair(m);
  ASSERT_EQ(pair.whole.below->step(), 5e-5);
  Model other = m;
  other.kind = ModelKind::track;
  const TrackAssembly whole(Comm::world(), other);
  BuiltTrack alone(whole.track, whole.line);
  double off = 0, most = 0;
  for (int n = 0; n < 600; ++n) {
    pair.step();
    alone.passage.advance();
    for (const std::size_t side : {0, 1}) {
      const std::int32_t at = alone.line.sleeper_unknown(before + 1, side);
      const double there = alone.passage.line_motion().displacement[at];
      off = std::max(off, std::abs(sleeper(pair, before + 1, side) - there));
      most = std::max(most, std::abs(there));
    }
  }
  verified::below("largest difference of a sleeper over its largest motion", "-", off / most,
                  rigid_ground);
}

}  // namespace
}  // namespace trackbed::model::two_rails_on_ground_test
