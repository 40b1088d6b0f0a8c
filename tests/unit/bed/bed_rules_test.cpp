// Incompatible values of the deck are reported, also if each value is within its limits.
#include <gtest/gtest.h>

#include "trackbed/bed/bed.hpp"
#include "unit/bed/rules.hpp"

namespace trackbed::bed::bed_rules_test {
namespace {

using Names = std::set<std::string>;

Names broken(const std::function<void(BedParameters&)>& change) {
  BedParameters bed;
  change(bed);
  return BrokenRules::of(bed);
}

TEST(BedRules, DefaultsHold) {
  EXPECT_EQ(BrokenRules::of(BedParameters{}), Names{});
  EXPECT_EQ(BrokenRules::of(PlatenParameters{}), Names{});
}

TEST(BedRules, RangesIncrease) {
  EXPECT_EQ(broken([](auto& bed) { bed.x = {2, 2}; }), Names{"x"});
  EXPECT_EQ(broken([](auto& bed) { bed.y = {0, -1}; }), Names{"y"});
  EXPECT_EQ(broken([](auto& bed) { bed.x = {0}; }), Names{"x"});
}

TEST(BedRules, CrestLiesBetweenTheSides) {
  EXPECT_EQ(broken([](auto& bed) { bed.crest = {-0.5, 0.2}; }), Names{});
  EXPECT_EQ(broken([](auto& bed) { bed.crest = {0.2}; }), Names{"crest"});
  EXPECT_EQ(broken([](auto& bed) { bed.crest = {0.2, -0.2}; }), Names{"crest"});
  EXPECT_EQ(broken([](auto& bed) { bed.crest = {-0.6, 0.2}; }), Names{"crest"});
}

// A slope of 2 falls by half of its horizontal extent.
TEST(Bed, EndsAtItsOutline) {
  BedParameters bed;
  EXPECT_EQ(bed.top_at(0.4, 0.3), 0.3);
  bed.crest = {-0.1, 0.2}, bed.slope = 2;
  EXPECT_EQ(bed.top_at(0, 0.3), 0.3);
  EXPECT_NEAR(bed.top_at(0.4, 0.3), 0.2, 1e-15);
  EXPECT_NEAR(bed.top_at(-0.3, 0.3), 0.2, 1e-15);
}

TEST(BedRules, GradingIsASieveCurve) {
  EXPECT_EQ(broken([](auto& bed) { bed.sieve = {22.4, 22.4, 40, 50, 63}; }), Names{"sieve"});
  EXPECT_EQ(broken([](auto& bed) { bed.sieve = {}; }), (Names{"sieve", "passing"}));
  EXPECT_EQ(broken([](auto& bed) { bed.passing = {0, 13, 47, 100}; }), Names{"passing"});
  EXPECT_EQ(broken([](auto& bed) { bed.passing = {5, 13, 47, 85, 100}; }), Names{"passing"});
  EXPECT_EQ(broken([](auto& bed) { bed.passing = {0, 50, 47, 85, 100}; }), Names{"passing"});
  EXPECT_EQ(broken([](auto& bed) { bed.passing = {0, 13, 47, 85, 99}; }), Names{"passing"});
}

TEST(BedRules, StonesCanBeGenerated) {
  EXPECT_EQ(broken([](auto& bed) { bed.pebble_radius = 0.008; }), Names{"pebble_radius"});
  EXPECT_EQ(broken([](auto& bed) { bed.pebble_radius = 0.008, bed.stone = StoneKind::disk; }),
            Names{});
  EXPECT_EQ(broken([](auto& bed) { bed.polyhedron.spheres = {6, 5}; }), Names{"spheres"});
  const auto clump = [](std::vector<double> spheres) {
    return broken([&](auto& bed) { bed.stone = StoneKind::clump, bed.clump = spheres; });
  };
  EXPECT_EQ(clump({0, 0, 0, 1}), Names{});
  EXPECT_EQ(clump({0, 0, 0, 1, 2}), Names{"clump"});
  EXPECT_EQ(clump({0, 0, 0, -1}), Names{"clump"});
}

}  // namespace
}  // namespace trackbed::bed::bed_rules_test
