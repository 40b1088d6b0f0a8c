// Inconsistent values in a deck of a track alone are reported; the libraries are complete.
#include <gtest/gtest.h>

#include <functional>

#include "trackbed/core/error.hpp"
#include "trackbed/track/passage.hpp"
#include "unit/bed/rules.hpp"

namespace trackbed::track::track_alone_rules_test {
namespace {

using Names = std::set<std::string>;

template <class T>
Names broken(const std::function<void(T&)>& change) {
  T parameters;
  change(parameters);
  return BrokenRules::of(parameters);
}

TEST(TrackAloneRules, DefaultsHold) {
  EXPECT_EQ(BrokenRules::of(TrackParameters{}), Names{});
  EXPECT_EQ(BrokenRules::of(TrainParameters{}), Names{});
  EXPECT_EQ(BrokenRules::of(IrregularityParameters{}), Names{});
}

TEST(TrackAloneRules, TheTrackIsSupportedAndFits) {
  using T = TrackParameters;
  EXPECT_EQ(broken<T>([](T& p) { p.support = Support::none; }), Names{});
  EXPECT_EQ(broken<T>([](T& p) { p.support = Support::none, p.ends = RailEnds::free; }),
            Names{"ends"});
  EXPECT_EQ(broken<T>([](T& p) { p.length = 60.1; }), Names{"length"});
  EXPECT_EQ(broken<T>([](T& p) { p.length = 0.2; }), (Names{"length", "run_in"}));
  EXPECT_EQ(broken<T>([](T& p) { p.run_in = 31; }), Names{"run_in"});
  EXPECT_EQ(broken<T>([](T& p) {
              p.support = Support::continuous;
              p.zones.resize(1);
              p.zones[0] = {.from = 1, .to = 2, .gap = 1e-3};
            }),
            Names{"zone[0].gap"});
  EXPECT_EQ(broken<PadParameters>([](PadParameters& p) { p.bilinear_at = 1e-4; }),
            Names{"bilinear_stiffness"});
  EXPECT_EQ(broken<TrackZone>([](TrackZone& z) { z.from = 2, z.to = 2; }), Names{"to"});
}

TEST(TrackAloneRules, ZonesWithTheirOwnSpacingFit) {
  using Zones = std::vector<TrackZone>;
  const auto zoned = [](const Zones& zones, double length = 60) {
    return broken<TrackParameters>([&](TrackParameters& p) { p.zones = zones, p.length = length; });
  };
  EXPECT_EQ(zoned({{.from = 12, .to = 15, .spacing = 0.75}}), Names{});
  EXPECT_EQ(zoned({{.from = 57, .to = 60, .spacing = 0.5}, {.from = 0, .to = 9, .spacing = 0.9}}),
            Names{});
  EXPECT_EQ(zoned({{.from = 12, .to = 15.1, .spacing = 0.75}}), (Names{"zone[0].to", "length"}));
  EXPECT_EQ(zoned({{.from = 12.1, .to = 15.1, .spacing = 0.75}}),
            (Names{"zone[0].from", "length"}));
  EXPECT_EQ(zoned({{.from = 12, .to = 15, .spacing = 0.75}}, 60.1), Names{"length"});
  EXPECT_EQ(
      zoned({{.from = 12, .to = 15, .spacing = 0.75}, {.from = 13.5, .to = 18, .spacing = 1}}),
      (Names{"zone[1].from", "zone[1].to"}));
  EXPECT_EQ(zoned({{.from = -3, .to = 3, .spacing = 0.75}}), Names{"zone[0].from"});
  EXPECT_EQ(zoned({{.from = 57, .to = 63, .spacing = 0.75}}), Names{"zone[0].to"});
}

TEST(TrackAloneRules, VehiclesHaveWhatTheirKindNeeds) {
  using V = VehicleParameters;
  EXPECT_EQ(broken<V>([](V& v) { v.like = "manchester_1"; }), Names{});
  EXPECT_EQ(broken<V>([](V& v) { v.kind = VehicleKind::wheel, v.length = 1; }), Names{"kind"});
  for (double V::*number : {&V::body_mass, &V::bogie_mass, &V::wheelset_mass, &V::wheelbase,
                            &V::primary_stiffness, &V::secondary_stiffness}) {
    V bogie = complete({.like = "x2_bogie"});
    EXPECT_TRUE(lacking(bogie).empty());
    bogie.*number = 0;
    EXPECT_EQ(lacking(bogie).size(), 1U);
  }
  EXPECT_EQ(broken<V>([](V& v) { v.kind = VehicleKind::forces, v.length = 1, v.axles = {0}; }),
            Names{"kind"});
  for (const V& known : vehicle_library()) EXPECT_TRUE(lacking(complete(known)).empty());
}

TEST(TrackAloneRules, IrregularitiesHaveTheirFileAndBand) {
  using I = IrregularityParameters;
  EXPECT_EQ(broken<I>([](I& p) { p.kind = IrregularityKind::file; }), Names{"file"});
  EXPECT_EQ(broken<I>([](I& p) { p.longest = 1; }), Names{"longest"});
}

// Names are also checked by the model itself.
TEST(TrackAloneRules, UnknownNamesAreInputErrors) {
  EXPECT_THROW(rail_section("60E2"), InputError);
  EXPECT_THROW(Train({.vehicles = {"nobody"}}, {}, 2), InputError);
  VehicleParameters empty;
  empty.name = "empty";
  EXPECT_THROW(Train({.vehicles = {"empty"}}, {empty}, 2), InputError);
}

// A rail without support has no static equilibrium.
TEST(TrackAlone, ATrackWithoutSupportIsAnError) {
  LineParameters p;
  p.track.support = Support::none;
  p.track.ends = RailEnds::free;
  const Line line(p);
  EXPECT_THROW(Statics{line.system()}, RunError);
}

// Shapes of the running surface where they begin, end and are deepest, m.
TEST(TrackAlone, DipsAreWhereTheyShouldBe) {
  IrregularityParameters p;
  p.at = 10;
  p.length = 2;
  p.depth = 1e-3;
  for (const auto kind :
       {IrregularityKind::versine, IrregularityKind::vee, IrregularityKind::joint}) {
    p.kind = kind;
    const Irregularity dip(p, 20);
    EXPECT_DOUBLE_EQ(dip.at(10), -1e-3);
    EXPECT_EQ(dip.at(9), 0);
    EXPECT_EQ(dip.at(11.5), 0);
    EXPECT_DOUBLE_EQ(dip.at(9.5), kind == IrregularityKind::joint ? -0.25e-3 : -0.5e-3);
  }
  p.kind = IrregularityKind::waves;
  p.waves = 2;
  const Irregularity waves(p, 20);
  EXPECT_NEAR(waves.at(11), -1e-3, 1e-15);
  EXPECT_NEAR(waves.at(13), -1e-3, 1e-15);
  EXPECT_EQ(waves.at(14.5), 0);
}

}  // namespace
}  // namespace trackbed::track::track_alone_rules_test
