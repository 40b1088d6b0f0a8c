// Sleepers whose spacing changes along the track, against tracks that are the same otherwise.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/verified.hpp"
#include "trackbed/model/footing.hpp"
#include "trackbed/model/parameters.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::spacing_test {
namespace {

// 24 m of 60E1 on sleepers every 0.6 m, without run-ins.
LineParameters plain() {
  LineParameters p;
  p.rail.theory = BeamTheory::euler;
  p.track.length = 24;
  p.track.run_in = 0;
  return p;
}

TEST(SleeperSpacing, PositionsFollowZones) {
  TrackParameters t = plain().track;
  t.zones = {{.from = 18, .to = 24, .spacing = 0.5}, {.from = 6, .to = 9, .spacing = 0.75}};
  EXPECT_EQ(t.sleepers(), 10U + 4U + 15U + 12U + 1U);
  EXPECT_DOUBLE_EQ(t.sleeper_x(10), 6);
  EXPECT_DOUBLE_EQ(t.sleeper_x(11), 6.75);
  EXPECT_DOUBLE_EQ(t.sleeper_x(15), 9.6);
  EXPECT_DOUBLE_EQ(t.sleeper_x(30), 18.5);
  EXPECT_DOUBLE_EQ(t.sleeper_x(41), 24);
  EXPECT_DOUBLE_EQ(t.least_spacing(), 0.5);
  LineParameters p = plain();
  p.track = t;
  const Line line(p);
  ASSERT_EQ(line.sleepers(), t.sleepers());
  for (std::size_t n = 0; n < line.sleepers(); ++n) {
    EXPECT_NEAR(line.sleeper_x(n), t.sleeper_x(n), 1e-12);
    EXPECT_EQ(line.nearest_sleeper(line.sleeper_x(n) + 0.2), n < 41 ? n : 41U);
  }
}

// Positions in the middle between two sleepers belong to the later one, as sums are rounded either
// way.
TEST(SleeperSpacing, MiddlesBelongToTheLaterSleeper) {
  const Line line(plain());
  for (std::size_t n = 0; n < 40; ++n)
    EXPECT_EQ(line.nearest_sleeper(0.6 * static_cast<double>(n) + 0.3), n + 1);
}

// A zone over the whole track equals another spacing of the track, bit by bit.
TEST(SleeperSpacing, AZoneOverTheWholeTrackIsItsSpacing) {
  LineParameters zoned = plain();
  zoned.track.spacing = 1.2;
  zoned.track.zones = {{.from = 0, .to = 24, .spacing = 0.6}};
  const Line one(zoned), other(plain());
  EXPECT_EQ((one.system().stiffness - other.system().stiffness).norm(), 0);
  EXPECT_EQ((one.system().mass - other.system().mass).norm(), 0);
}

// Every second sleeper of a zone with half the spacing has nearly no pad: the track is then that
// of the usual spacing. Cubic elements are exact for forces at their nodes, however long they are.
TEST(SleeperSpacing, SleepersWithoutPadsDoNotSupport) {
  constexpr double weak = 1e-9;
  LineParameters dense = plain();
  dense.track.zones = {{.from = 9.6, .to = 14.4, .spacing = 0.3}};
  for (int k = 0; k < 8; ++k) {
    const double x = 9.9 + 0.6 * k;
    dense.track.zones.push_back({.from = x - 0.1, .to = x + 0.1, .pad = weak});
  }
  const Line one(dense), other(plain());
  EXPECT_EQ(one.sleepers(), other.sleepers() + 8);
  const verified::Tolerance close{1e-7, "pads of 1e-9 of the usual stiffness, times eight"};
  for (const double x : {12.0, 9.6, 6.0}) {
    const Vector u = at_rest(one, x, 100e3), v = at_rest(other, x, 100e3);
    for (const double at : {8.4, 12.0, 12.6}) {
      const double expected = other.at(at).deflection(v);
      verified::near(fmt::format("rail at {:g} m, load at {:g} m", at, x), "m",
                     one.at(at).deflection(u), expected, close.of(expected));
    }
    const double moment = other.bending_moment(12, v);
    verified::near(fmt::format("bending moment at 12 m, load at {:g} m", x), "N m",
                   one.bending_moment(12, u), moment, close.of(moment));
  }
}

// Far from the ends, N sleepers in a length carry the load of the Winkler bed k N/length: half the
// spacing with half the stiffness hardly changes a deflection that extends over many sleepers.
TEST(SleeperSpacing, HalfTheSpacingOfHalfTheStiffnessIsNearlyTheSameBed) {
  LineParameters dense = plain(), usual = plain();
  for (LineParameters* p : {&dense, &usual}) p->ballast.stiffness = 5e6;
  dense.track.zones = {{.from = 6, .to = 18, .bed = 0.5, .pad = 0.5, .spacing = 0.3}};
  const Line one(dense), other(usual);
  const double here = one.at(12).deflection(at_rest(one, 12, 100e3));
  const double there = other.at(12).deflection(at_rest(other, 12, 100e3));
  EXPECT_NEAR(here, there, 0.02 * std::abs(there));
  EXPECT_NE(here, there);
}

// Footprints on a ground are where the sleepers are.
TEST(SleeperSpacing, FootprintsFollowZones) {
  model::Model m;
  m.kind = model::ModelKind::track_on_ground;
  m.track.line.track = plain().track;
  m.track.line.track.zones = {{.from = 7.2, .to = 8.4, .spacing = 0.4}};
  m.footing = {.before = 11, .count = 6, .first = 1, .width = 0.3};
  const auto prints = model::footprints_of(m);
  ASSERT_EQ(prints.size(), 6U);
  const std::vector<double> x{1, 1.6, 2, 2.4, 2.8, 3.4};  // m
  for (std::size_t k = 0; k < x.size(); ++k)
    EXPECT_NEAR((prints[k].x[0] + prints[k].x[1]) / 2, x[k], 1e-12);
}

}  // namespace
}  // namespace trackbed::track::spacing_test
