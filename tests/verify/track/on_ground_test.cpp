// Sleepers on ballast springs on a ground of elements: static against springs in series; in motion
// the order, energy and the limit of a rigid ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support/verified.hpp"
#include "verify/ground/half_space.hpp"
#include "verify/track/on_ground_scene.hpp"

namespace trackbed::model::on_ground_test {
namespace {

using par::Comm;

// A sleeper whose footprint is the whole ground: a column, H/(M A) with M = E (1-nu)/((1+nu)
// (1-2nu)), exact with elements; above it the ballast spring, and a pad of `under` m/N.
void check_column(double under) {
  Model m = at_rest(model_of(1, {60e6, 0.3, 2000}));
  if (under > 0) m.track.line.under_sleeper = {.stiffness = 1 / under, .damping = 10e3};
  Pair pair(m);
  pair.run(1.0);
  const double modulus = 60e6 * 0.7 / (1.3 * 0.4), area = 0.6 * 1.2, height = 1.2;
  const track::Passage& passage = pair.built.passage;
  const double force = pair.built.line.seat_force(before, passage.line_motion().displacement,
                                                  passage.line_motion().velocity);
  const double series = under + 1 / 100e6 + height / (modulus * area);
  verified::near("sleeper per seat force", "m/N", -sleeper(pair, before) / force, series,
                 almost_static.of(series));
  verified::near("force on the ground over seat force", "-", passage.ground_force(before) / force,
                 1, almost_static);
}

TEST(TrackOnGround, SpringAndColumnInSeries) { check_column(0); }
TEST(TrackOnGround, PadSpringAndColumnInSeries) { check_column(1 / 80e6); }

// In space, a footprint on a part of the top that cuts its elements. The compliance of the ground
// is that of a static solve of another ground under the weights.
TEST(TrackOnGround, SpringAndBlockInSeries) {
  Model m = model_of(1, {60e6, 0.3, 2000});
  m.dimension = Dimension::space;
  m.ground = fem::box({2.4, 1.8, 1.2}, {8, 6, 4}, {60e6, 0.3, 2000});
  m.ground.base = fem::Base::fixed;
  m.ground.sides = fem::Sides::roller;
  m.footing.first = 1.1, m.footing.width = 0.5, m.footing.length = 1.1, m.footing.y = 0.8;
  Pair pair(at_rest(m));
  pair.run(1.0);
  fem::Ground ground(Comm::world(), fem::half_space(m.ground), Dimension::space, 1);
  const couple::Footprints print(Comm::world(), ground.top(), ground.own_top(),
                                 {{{0.85, 1.35}, {0.25, 1.35}}});
  std::vector<Vec3> load(ground.top().nodes(), Vec3::Zero());
  print.add_forces(std::array{1e5}, load);
  fem::load_statically(ground, load);
  std::vector<couple::Footprints::Values> height{{{}, 1.0}};
  for (const auto node : ground.own_top())
    height[0].own.push_back(ground.top_motion(node).displacement.z());
  const double series = 1 / 100e6 - print.means(height)[0][0] / 1e5;
  verified::near("sleeper per force on the ground", "m/N",
                 -sleeper(pair, before) / pair.built.passage.ground_force(before), series,
                 almost_static.of(series));
}

// A footprint on the whole top in space gives a uniform settlement, with few elements as with many:
// a column again.
TEST(TrackOnGround, AUniformPressureGivesAUniformSettlement) {
  for (const std::int64_t across : {1, 2, 5}) {
    const fem::GroundParameters box =
        fem::box({1.2, 0.9, 1.2}, {across, across, 4}, {60e6, 0.3, 2000});
    fem::Ground ground(Comm::world(), fem::half_space(box), Dimension::space, 1);
    const couple::Footprints print(Comm::world(), ground.top(), ground.own_top(),
                                   {{{0, 1.2}, {0, 0.9}}});
    std::vector<Vec3> load(ground.top().nodes(), Vec3::Zero());
    print.add_forces(std::array{1e5}, load);
    fem::load_statically(ground, load);
    const double column = 1e5 / (1.2 * 0.9) * 1.2 / (60e6 * 0.7 / (1.3 * 0.4));
    double off = 0;
    for (const auto node : ground.own_top())
      off = std::max(off, std::abs(ground.top_motion(node).displacement.z() / column + 1));
    verified::below("largest difference of the top from a column, " + std::to_string(across) +
                        " elements each way",
                    "-", Comm::world().max(off),
                    {1e-8, "constant stress is exact: solver, 1e-9 times a condition of ten"});
  }
}

// Every 0.4 ms: m, of a sleeper and of the ground below it, under a growing force of 50 Hz.
using Histories = std::array<std::vector<double>, 2>;
Histories shaken(double step) {
  Model m = model_of(5, {60e6, 0.3, 2000});
  auto& force = m.track.passage.forces[0];
  force.kind = track::ForceKind::harmonic, force.frequency = 50, force.rise = 0.02;
  m.track.passage.step = step;
  Pair pair(m);
  Histories found;
  for (int row = 0; row < 75; ++row) {
    pair.run(4e-4);
    found[0].push_back(sleeper(pair, before + 2));
    found[1].push_back(pair.built.passage.ground_below(before + 2).height);
  }
  return found;
}

TEST(TrackOnGround, IsOfSecondOrder) {
  const Histories a = shaken(8e-5), b = shaken(4e-5), c = shaken(2e-5);
  for (const std::size_t k : {0, 1}) {
    const std::string of = k == 0 ? "sleeper" : "ground";
    verified::near("order in the step, " + of, "-",
                   std::log2(distance(a[k], b[k]) / distance(b[k], c[k])), 2, second_order);
    verified::below("change from steps of 0.04 to 0.02 ms, root mean square, " + of, "m",
                    distance(b[k], c[k]),
                    {2e-8, "(omega dt)^2 / 16 = 1e-5 of 0.5 mm at 50 Hz: 5e-9 m, four times"});
  }
}

// The ground carries both rails of a track that is computed once: the energy of the track must
// count for both rails, otherwise the sum would change by half of the energy exchanged with the
// ground.
TEST(TrackOnGround, KeepsEnergyOfBothRails) {
  Model m = model_of(5, {60e6, 0.3, 2000});
  m.track.line.ballast.damping = m.track.line.pad.damping = 0;
  m.footing.rails = 2;
  m.track.passage.step = 2e-5;
  Pair pair(m);
  pair.run(0.0101);
  const double after = pair.energy();
  double furthest = 0, in_ground = 0;
  for (int n = 0; n < 2500; ++n) {
    pair.step();
    const auto of = pair.whole.below->energies(pair.built.passage);
    furthest = std::max(furthest, std::abs(pair.energy() - after));
    in_ground = std::max(in_ground, of.ground.kinetic + of.ground.elastic);
  }
  verified::above("largest fraction of the energy in the ground", "-", in_ground / after,
                  {0.1, "separates: the ground takes part"});
  verified::below("largest change of energy in 50 ms", "-", furthest / after,
                  {5e-5, "leapfrog: (omega h / 2)^2 = 4e-5 at 100 Hz"});
}

// Without dampers the energy of the impact is conserved, at the longest step that the program uses,
// over 40000 steps; the energy that leapfrog conserves differs from this one by (h w/2)^2.
TEST(TrackOnGround, KeepsEnergyAtTheLongestStep) {
  Model m = model_of(5, {60e6, 0.3, 2000});
  m.track.line.ballast.damping = m.track.line.pad.damping = 0;
  Pair pair(m);
  pair.run(0.01);
  double begin = 0, end = 0, most = 0;
  constexpr int steps = 40000, part = 400;
  for (int n = 0; n < steps / part; ++n) {
    pair.run(part * pair.whole.below->step());
    const double energy = pair.energy();
    if (n < 10) begin += energy / 10;
    if (n >= steps / part - 10) end += energy / 10;
    most = std::max(most, energy);
  }
  verified::near("mean energy after 36000 steps over that of the first 4000", "-", end / begin, 1,
                 mean_energy);
  verified::below("largest energy over the first mean", "-", most / begin, largest_energy);
  const auto of = pair.whole.below->energies(pair.built.passage);
  const double held = of.ground.kinetic + of.ground.elastic;
  verified::near("energy of the ground over the work of the ballast on it", "-",
                 held / of.given_to_ground, 1, ground_energy);
  const auto balance = pair.whole.below->balance();
  for (const char* name : {"force", "moment", "work"})
    verified::below(std::string("largest imbalance of ") + name, "-", balance[name].get<double>(),
                    rounding_of_sums);
}

// With hanging sleepers and pads compressed beyond bilinear_at energy is conserved. Relative to the
// energy after the impact.
TEST(TrackOnGround, KeepsEnergyOfBilinearPadsAndGaps) {
  Model m = model_of(5, {60e6, 0.3, 2000});
  track::LineParameters& line = m.track.line;
  line.ballast.damping = line.pad.damping = 0;
  line.pad.bilinear_at = 2e-5, line.pad.bilinear_stiffness = 400e6;
  line.track.zones = {{.from = 4.7, .to = 6.1, .gap = 5e-5}};  // three sleepers
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
  verified::above("largest fraction of the energy in bilinear pads and closed gaps", "-",
                  in_stops / after, {0.1, "separates: pads and gaps take part"});
  verified::below("largest change of energy in 50 ms", "-", furthest / after, corners);
}

// A ground a million times as stiff and as heavy, with the same wave speeds, equals the track alone
// except for its compliance of 1e-6 of that of the ballast.
TEST(TrackOnGround, ARigidGroundEqualsTheTrackAlone) {
  Model m = model_of(5, {60e12, 0.3, 2000e6});
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
    const std::int32_t at = alone.line.sleeper_unknown(before + 2);
    const double there = alone.passage.line_motion().displacement[at];
    off = std::max(off, std::abs(sleeper(pair, before + 2) - there));
    most = std::max(most, std::abs(there));
  }
  verified::below("largest difference of a sleeper over its largest motion", "-", off / most,
                  rigid_ground);
}

}  // namespace
}  // namespace trackbed::model::on_ground_test
