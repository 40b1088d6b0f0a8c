// Effect of zones and run-in on the supports of a track alone.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "trackbed/track/line.hpp"

namespace trackbed::track::supports_test {
namespace {

using Zones = std::vector<TrackZone>;

LineParameters with(const Zones& zones) {
  LineParameters p;
  p.track.length = 24;
  p.track.zones = zones;
  return p;
}

// Stiffness of the spring on the ground below the sleeper at x over that of a track without zones.
double bed(const LineParameters& p, double x) {
  LineParameters none = p;
  none.track.zones.clear();
  const Line line(p), plain(none);
  return line.ground_spring(line.nearest_sleeper(x))[0] /
         plain.ground_spring(plain.nearest_sleeper(x))[0];
}

// A sleeper on the common border belongs to the second zone only, the last sleeper of the track to
// the zone that ends there.
TEST(Zones, AdjacentZonesEqualOneZone) {
  const auto one = with({{.from = 0, .to = 24, .bed = 0.5}});
  const auto two = with({{.from = 0, .to = 12, .bed = 0.5}, {.from = 12, .to = 24, .bed = 0.5}});
  for (const double x : {0.0, 11.4, 12.0, 12.6, 24.0}) {
    EXPECT_NEAR(bed(one, x), 0.5, 1e-12) << x;
    EXPECT_NEAR(bed(two, x), 0.5, 1e-12) << x;
  }
  EXPECT_NEAR(bed(with({{.from = 0, .to = 12, .bed = 0.5}}), 12), 1, 1e-12);
  EXPECT_NEAR(bed(with({{.from = 12, .to = 18, .bed = 0.5}}), 12), 0.5, 1e-12);
}

// Factors multiply; the largest gap counts, in any order of the zones.
TEST(Zones, OverlappingZones) {
  const Zones over = {{.from = 0, .to = 12.3, .bed = 0.5, .gap = 1e-3},
                      {.from = 11.7, .to = 24, .bed = 0.5, .gap = 2e-4}};
  EXPECT_NEAR(bed(with(over), 12), 0.25, 1e-12);
  const std::vector<std::pair<double, double>> wanted = {{11.4, 1e-3}, {12, 1e-3}, {12.6, 2e-4}};
  for (const Zones& zones : {over, Zones{over[1], over[0]}}) {
    const Line line(with(zones));
    for (const auto& [x, gap] : wanted) {
      const std::int32_t stop = line.ground_stop(line.nearest_sleeper(x));
      ASSERT_GE(stop, 0);
      EXPECT_EQ(line.stops()[static_cast<std::size_t>(stop)].gap, gap) << x;
    }
  }
}

// A zone over the whole track equals other values of pads, sleepers and under-sleeper pads
// everywhere; a zone over a part of it does not.
TEST(Zones, FactorsEqualOtherValues) {
  constexpr double z = 1.7;
  for (const Dimension dimension : {Dimension::plane, Dimension::space})
    for (const auto& [model, inertia] : {std::pair{SleeperModel::rigid, 150.0},
                                         {SleeperModel::rigid, 0.0},
                                         {SleeperModel::beam, 0.0}}) {
      LineParameters p = with({{.from = 0, .to = 24, .pad = z, .sleeper = z}});
      p.track.dimension = dimension;
      p.track.sleeper.model = model;
      p.pad.bilinear_at = 1e-4, p.pad.bilinear_stiffness = 500e6;
      if (model == SleeperModel::rigid) {
        p.track.sleeper_inertia = dimension == Dimension::space ? inertia : 0;
        p.under_sleeper = {.stiffness = 80e6, .damping = 20e3};
        p.track.zones[0].under_sleeper_pad = z;
      }
      LineParameters other = p, part = p;
      part.track.zones[0].to = 12;
      other.track.zones.clear();
      for (double* value : {&other.pad.stiffness, &other.pad.damping, &other.pad.bilinear_stiffness,
                            &other.track.sleeper_mass, &other.track.sleeper_inertia,
                            &other.under_sleeper.stiffness, &other.under_sleeper.damping})
        *value *= z;
      const auto difference = [](const Line& one, const Line& two, Sparse LinearSystem::*of) {
        return Sparse(one.system().*of - two.system().*of).norm() / (two.system().*of).norm();
      };
      for (Sparse LinearSystem::*of :
           {&LinearSystem::mass, &LinearSystem::damping, &LinearSystem::stiffness}) {
        EXPECT_LT(difference(Line(p), Line(other), of), 1e-14);
        EXPECT_GT(difference(Line(part), Line(other), of), 1e-3);
      }
      const Line zoned(p), plain(other);
      Vector compressed = Vector::Zero(zoned.system().mass.rows());
      const Vector rest = compressed;
      compressed[zoned.sleeper_unknown(20)] = 2 * p.pad.bilinear_at;
      const double force = plain.seat_force(20, compressed, rest);
      EXPECT_NEAR(zoned.seat_force(20, compressed, rest), force, 1e-12 * force);
      ASSERT_EQ(zoned.stops().size(), plain.stops().size());
      for (std::size_t i = 0; i < zoned.stops().size(); ++i) {
        EXPECT_EQ(zoned.stops()[i].gap, plain.stops()[i].gap);
        EXPECT_NEAR(zoned.stops()[i].stiffness, plain.stops()[i].stiffness,
                    1e-14 * plain.stops()[i].stiffness);
      }
    }
}

// With a ballast mass as without.
TEST(Zones, ScaleTheSpringBelowTheBallastMass) {
  LineParameters p = with({{.from = 9.5, .to = 14.5, .bed = 3}});
  p.ballast.mass = 500;
  EXPECT_NEAR(bed(p, 12), 3, 1e-12);
  EXPECT_NEAR(bed(p, 9), 1, 1e-12);
  const Line massless(with({})), line(p);
  for (const std::size_t i : {std::size_t{0}, std::size_t{3}, std::size_t{15}})
    for (const std::size_t k : {0, 1}) {
      const double of_mass = k == 0 ? p.ballast.below_stiffness : p.ballast.below_damping;
      const double without = k == 0 ? p.ballast.stiffness : p.ballast.damping;
      const double run_in = massless.ground_spring(i)[k] / without;
      EXPECT_NEAR(line.ground_spring(i)[k] / of_mass, run_in, 1e-12 * run_in) << i;
    }
  EXPECT_NEAR(line.ground_spring(0)[0], 100 * p.ballast.below_stiffness, 1);
}

// In the run-in the stiffness of a pad is multiplied by a factor and bilinear_at is divided by it:
// at twice that compression the force is the same everywhere.
TEST(RunIn, BilinearPadsBecomeStifferEarlier) {
  LineParameters p = with({});
  p.track.ends = RailEnds::free;
  p.pad.bilinear_at = 1e-4;
  p.pad.bilinear_stiffness = 500e6;
  const Line line(p);
  const Vector rest = Vector::Zero(line.system().mass.rows());
  ASSERT_EQ(line.stops().size(), line.sleepers());
  for (const std::size_t i : {std::size_t{0}, std::size_t{4}, std::size_t{20}}) {
    const double factor = line.ground_spring(i)[0] / p.ballast.stiffness;
    EXPECT_EQ(factor > 1, i < 10);
    EXPECT_NEAR(line.stops()[i].gap, p.pad.bilinear_at / factor, 1e-15);
    EXPECT_NEAR(line.stops()[i].stiffness, (p.pad.bilinear_stiffness - p.pad.stiffness) * factor,
                1);
    Vector compressed = rest;
    compressed[line.sleeper_unknown(i)] = 2 * p.pad.bilinear_at / factor;
    const double force = (p.pad.stiffness + p.pad.bilinear_stiffness) * p.pad.bilinear_at;
    EXPECT_NEAR(line.seat_force(i, compressed, rest), force, 1e-9 * force) << i;
  }
}

}  // namespace
}  // namespace trackbed::track::supports_test
