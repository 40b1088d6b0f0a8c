// Inconsistent values of the deck are reported.
#include <gtest/gtest.h>

#include "trackbed/track/sleepers.hpp"
#include "unit/bed/rules.hpp"

namespace trackbed::track::track_rules_test {
namespace {

using Names = std::set<std::string>;

TEST(TrackRules, DefaultsHold) {
  EXPECT_EQ(BrokenRules::of(SleeperParameters{}), Names{});
  EXPECT_EQ(BrokenRules::of(SeatLoadParameters{}), Names{});
}

TEST(TrackRules, SleepersFitAndHaveKnownDegreesOfFreedom) {
  const auto broken = [](const std::function<void(SleeperParameters&)>& change) {
    SleeperParameters p;
    change(p);
    return BrokenRules::of(p);
  };
  EXPECT_EQ(broken([](auto& p) { p.free = {"x", "w"}; }), Names{"free"});
  EXPECT_EQ(broken([](auto& p) { p.free = {"x", "x"}; }), Names{"free"});
  EXPECT_EQ(broken([](auto& p) { p.free = {}; }), Names{});
  EXPECT_EQ(broken([](auto& p) { p.bevel = 0.145; }), Names{"bevel"});
  EXPECT_EQ(broken([](auto& p) { p.spacing = 0.29; }), Names{"spacing"});
  EXPECT_EQ(broken([](auto& p) { p.spacing = 0.29, p.count = 1; }), Names{});
}

TEST(TrackRules, LoadsHaveWhatTheirKindNeeds) {
  const auto broken = [](const std::function<void(SeatLoadParameters&)>& change) {
    SeatLoadParameters p;
    change(p);
    return BrokenRules::of(p);
  };
  EXPECT_EQ(broken([](auto& p) { p.kind = SeatLoadKind::table; }), Names{"file"});
  EXPECT_EQ(broken([](auto& p) { p.kind = SeatLoadKind::table, p.file = "a.csv"; }), Names{});
  EXPECT_EQ(broken([](auto& p) { p.ratio = 1; }), Names{"ratio"});
}

}  // namespace
}  // namespace trackbed::track::track_rules_test
