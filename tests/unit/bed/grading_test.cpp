// Sizes drawn by number give the sieve curve by mass, for all kinds of stones.
#include "bed/grading.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "bed/mix.hpp"
#include "bed/shapes.hpp"
#include "trackbed/core/error.hpp"
#include "unit/bed/rules.hpp"

namespace trackbed::bed::grading_test {
namespace {

constexpr double rounding = 1e-12;
constexpr int many = 20000;

// Per cent of the mass that passes `sieve` (m), for evenly distributed draws.
double passing(const Mix& mix, double sieve, int dimension) {
  double below = 0, all = 0;
  for (std::uint64_t i = 0; i < many; ++i) {
    const Draw draw = mix.draw(i, many);
    const auto& shape = mix.templates()[static_cast<std::size_t>(draw.shape)];
    const double mass = shape.volume * std::pow(draw.scale, dimension);
    all += mass;
    if (shape.sieve * draw.scale <= sieve) below += mass;
  }
  return 100 * below / all;
}

void expect_grading(const BedParameters& bed, Dimension dimension, double tolerance) {
  const Mix mix(bed, dimension);
  for (std::size_t k = 0; k < bed.sieve.size(); ++k)
    EXPECT_NEAR(passing(mix, 1e-3 * bed.sieve[k], dimension == Dimension::plane ? 2 : 3),
                bed.passing[k], tolerance)
        << bed.sieve[k] << " mm";
}

TEST(Grading, QuantilesMatchTheSieves) {
  const BedParameters bed;
  for (const int dimension : {2, 3}) {
    const Grading grading({0.02, 0.04, 0.05}, {0, 40, 100}, dimension);
    EXPECT_NEAR(grading.by_mass(0), 0.02, rounding);
    EXPECT_NEAR(grading.by_mass(0.4), 0.04, rounding);
    EXPECT_NEAR(grading.by_mass(1), 0.05, rounding);
    EXPECT_NEAR(grading.by_mass(0.2), std::sqrt(0.02 * 0.04), rounding);
    EXPECT_NEAR(grading.by_number(0), 0.02, rounding);
    EXPECT_NEAR(grading.by_number(1), 0.05, rounding);
    EXPECT_LT(grading.by_number(0.5), grading.by_mass(0.5));  // most stones are small
    double mean = 0;
    for (int i = 0; i < many; ++i)
      mean += std::pow(grading.by_number((i + 0.5) / many), dimension) / many;
    EXPECT_NEAR(mean / grading.mean_power(), 1, 1e-6);  // midpoint rule of 20000 points
  }
}

// Limits of the standards: sieve, least and most that passes. EN 13450:2002, category A, which the
// Chinese special class equals; TB/T 2140, first class for new lines; AS 2758.7:1996, nominal 60
// from memory.
TEST(Grading, LimitsAreThoseOfTheStandards) {
  using Rows = std::vector<std::array<double, 3>>;
  const Rows en13450 = {{22.4, 0, 3}, {31.5, 1, 25}, {40, 30, 65}, {50, 70, 99}, {63, 100, 100}};
  const std::map<GradingKind, Rows> published = {
      {GradingKind::en13450_a, en13450},
      {GradingKind::china_special, en13450},
      {GradingKind::china_first,
       {{16, 0, 5}, {25, 5, 15}, {35.5, 25, 40}, {45, 55, 75}, {56, 92, 97}, {63, 97, 100}}},
      {GradingKind::as2758_60,
       {{13.2, 0, 2}, {19, 0, 5}, {26.5, 0, 20}, {37.5, 20, 65}, {53, 85, 100}, {63, 100, 100}}}};
  for (const auto& [kind, rows] : published) {
    const GradingLimits& limits = limits_of(kind);
    ASSERT_EQ(limits.sieve.size(), rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
      EXPECT_EQ((std::array{limits.sieve[k], limits.low[k], limits.high[k]}), rows[k]);
  }
}

// 20000 draws: one of the largest is 0.02 % of the mass.
TEST(Grading, DisksAndSpheresAreGradedByMass) {
  BedParameters bed;
  bed.stone = StoneKind::disk;
  expect_grading(bed, Dimension::plane, 0.05);
  expect_grading(bed, Dimension::space, 0.05);
}

TEST(Grading, ClumpsAreGradedByTheirSieve) {
  BedParameters bed;
  bed.stone = StoneKind::clump;
  bed.clump = {0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 0.7};
  expect_grading(bed, Dimension::plane, 0.05);
  expect_grading(bed, Dimension::space, 0.05);
}

TEST(Grading, PolyhedraAreGradedByTheirSieve) {
  BedParameters bed;
  bed.stone = StoneKind::polyhedra;
  bed.shapes = 7;
  expect_grading(bed, Dimension::space, 0.1);
}

TEST(Grading, OutlinesRepresentEqualFractionsOfTheMass) {
  BedParameters bed;
  bed.shapes = 40;
  expect_grading(bed, Dimension::plane, 100.0 / 40);  // a sieve may cut off half a shape: 1.25 %
  bed.shapes = 200;
  expect_grading(bed, Dimension::plane, 100.0 / 200);
}

TEST(Grading, EmptyClassesAreSkipped) {
  BedParameters bed;
  bed.stone = StoneKind::disk;
  bed.sieve = {10, 20, 30, 40, 50};
  bed.passing = {0, 0, 50, 50, 100};
  expect_grading(bed, Dimension::plane, 0.1);
  const Mix mix(bed, Dimension::plane);
  for (std::uint64_t i = 0; i < many; ++i) {
    const double size = mix.draw(i, many).scale;
    EXPECT_TRUE((size >= 0.02 && size <= 0.03) || (size >= 0.04 && size <= 0.05)) << size;
  }
}

// All stones pass before the last sieve: the largest is that of the last class with stones.
TEST(Grading, ClassesWithoutStonesAtTheCoarseEndAreSkipped) {
  BedParameters bed;
  bed.stone = StoneKind::disk;
  bed.sieve = {10, 20, 30, 40};
  bed.passing = {0, 40, 100, 100};
  expect_grading(bed, Dimension::space, 0.1);
  const Mix mix(bed, Dimension::space);
  EXPECT_NEAR(mix.largest_bound(), 0.015, 1e-12);  // radius of a ball of 30 mm
}

// Generated stones are within the limits of the standard at every sieve.
TEST(Grading, StandardsAreWithinTheirLimits) {
  for (const GradingKind kind : {GradingKind::en13450_a, GradingKind::china_special,
                                 GradingKind::china_first, GradingKind::as2758_60}) {
    BedParameters bed;
    bed.stone = StoneKind::disk;
    bed.grading = kind;
    BrokenRules rules;
    bed.declare(rules);  // sets sieves and passing
    EXPECT_EQ(BrokenRules::of(bed), std::set<std::string>{});
    const GradingLimits& limits = limits_of(kind);
    ASSERT_EQ(bed.sieve, limits.sieve);
    const Mix mix(bed, Dimension::space);
    for (std::size_t k = 0; k < limits.sieve.size(); ++k) {
      const double passes = passing(mix, 1e-3 * limits.sieve[k], 3);
      EXPECT_NEAR(passes, bed.passing[k], 0.05);
      EXPECT_GE(passes, limits.low[k] - 0.05) << limits.sieve[k] << " mm";
      EXPECT_LE(passes, limits.high[k] + 0.05) << limits.sieve[k] << " mm";
      EXPECT_EQ(bed.grading_table()[4 * k + 2], limits.low[k]);
    }
  }
}

TEST(Shapes, TemplatesHaveTheMassOfTheSolid) {
  BedParameters bed;
  bed.clump = {5, 5, 5, 0.01, 5, 5, 5.03, 0.01};  // two separate spheres, extent 0.05
  const dem::Template pair = clump_stone(bed, Dimension::space);
  const double r = 0.2, sphere = 4 * std::numbers::pi / 3 * r * r * r;
  EXPECT_NEAR(pair.volume, 2 * sphere, 2e-3 * sphere);
  EXPECT_NEAR(std::abs(pair.pieces[0].core.vertices[0].norm()), 0.3, 1e-6);
  EXPECT_NEAR(pair.gyration.maxCoeff(), 0.4 * r * r + 0.09, 1e-4);
  const dem::Template stone = outline_stone(bed, 0.04, 3);
  EXPECT_NEAR(stone.sieve, 0.04, 1e-6 * 0.04);
  for (const dem::Piece& piece : stone.pieces) {
    EXPECT_EQ(piece.radius, bed.pebble_radius);
    EXPECT_EQ(piece.core.vertices[0].y(), 0);
  }
}

TEST(Shapes, CompoundsAreThePolyhedraInPieces) {
  BedParameters bed;
  bed.polyhedron.vertices = 12;
  bed.stone = StoneKind::polyhedra;
  const dem::Template whole = polyhedron_stone(bed, 4);
  ASSERT_EQ(whole.pieces.size(), 1u);
  EXPECT_EQ(whole.pieces[0].core.vertices.size(), 12u);
  EXPECT_EQ(whole.pieces[0].core.faces.size(), 20u);
  EXPECT_GT((polyhedron_stone(bed, 5).gyration - whole.gyration).norm(), 1e-3);
  bed.stone = StoneKind::compound;
  const dem::Template cut = polyhedron_stone(bed, 4);
  ASSERT_EQ(cut.pieces.size(), 3u);
  EXPECT_EQ(cut.volume, whole.volume);
  EXPECT_EQ(cut.sieve, whole.sieve);
  EXPECT_EQ(cut.gyration, whole.gyration);
  // The union of the pieces, by columns (3e-4 at 192), is that stone.
  const geom::Solid all = geom::union_solid(cut.pieces, 192);
  EXPECT_NEAR(all.volume / whole.volume, 1, 1e-3);
  EXPECT_LT(all.centre.norm(), 1e-3);
  EXPECT_NEAR((all.gyration - whole.gyration).norm() / whole.gyration.norm(), 0, 2e-3);
}

// Every generated shape, whole or in pieces, measured by callipers on its contact geometry.
TEST(Shapes, PolyhedraHaveTheProportionsOfTheDeck) {
  constexpr double exact = 1e-6;
  BedParameters bed;
  bed.polyhedron.vertices = 12;
  for (const StoneKind kind : {StoneKind::polyhedra, StoneKind::compound})
    for (const std::int64_t seed : {1, 2, 3}) {
      bed.stone = kind, bed.seed = seed;
      bed.polyhedron.elongation = 0.95 - 0.15 * static_cast<double>(seed);
      bed.polyhedron.flatness = 0.9 - 0.1 * static_cast<double>(seed);
      bed.polyhedron.rounding = 0.02 * static_cast<double>(seed);
      for (std::int64_t k = 0; k < 8; ++k) {
        const dem::Template made = polyhedron_stone(bed, k);
        const geom::Callipers box = geom::callipers_of(made.pieces);
        EXPECT_NEAR(box.width / box.length, bed.polyhedron.elongation, exact);
        EXPECT_NEAR(box.thickness / box.width, bed.polyhedron.flatness, exact);
        EXPECT_GT(made.sieve, (1 - exact) * box.thickness);
        EXPECT_LT(made.sieve, (1 + exact) * box.width);
      }
    }
}

TEST(Shapes, FilledPolyhedraHaveSpheresFromFewestToMost) {
  BedParameters bed;
  bed.stone = StoneKind::clump;
  bed.polyhedron.spheres = {5, 7};
  bed.shapes = 6;
  const std::vector<std::size_t> wanted = {5, 5, 6, 6, 7, 7};
  for (std::size_t k = 0; k < wanted.size(); k += 2) {
    const dem::Template made = polyhedron_stone(bed, static_cast<std::int64_t>(k));
    EXPECT_EQ(made.pieces.size(), wanted[k]);
    for (const dem::Piece& piece : made.pieces) EXPECT_EQ(piece.core.vertices.size(), 1u);
  }
}

TEST(Shapes, ImpossibleStonesAreBadInput) {
  BedParameters bed;
  EXPECT_THROW(Mix(bed, Dimension::space), InputError);
  bed.pebble_radius = 0.02;
  EXPECT_THROW(Mix(bed, Dimension::plane), InputError);
  for (const StoneKind kind : {StoneKind::clump, StoneKind::polyhedra, StoneKind::compound}) {
    bed.stone = kind;
    EXPECT_THROW(Mix(bed, Dimension::plane), InputError);
  }
}

}  // namespace
}  // namespace trackbed::bed::grading_test
