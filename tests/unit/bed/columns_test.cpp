// Initial stones do not overlap and are numbered from left to right.
#include "bed/columns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "bed/plate.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::bed::columns_test {
namespace {

struct Scene {
  BedParameters bed;
  dem::Domain domain;
  explicit Scene(Dimension dimension, StoneKind kind) {
    bed.stone = kind;
    bed.x = {1, 4};
    bed.height = dimension == Dimension::plane ? 0.4 : 0.2;
    bed.clump = {0, 0, 0, 1, 1, 0, 0, 1};
    bed.shapes = 5;
    domain.dimension = dimension;
    domain.low = {1, -0.5, -0.2};
    domain.high = {4, 0.5, 9};
  }
  std::vector<dem::NewParticle> build() const {
    const Mix mix(bed, domain.dimension);
    const Columns columns(bed, domain, mix);
    std::vector<dem::NewParticle> stones;
    for (std::int64_t c = 0; c < columns.count(); ++c) columns.build(c, stones);
    return stones;
  }
};

class ColumnsOf : public ::testing::TestWithParam<std::pair<Dimension, StoneKind>> {};

TEST_P(ColumnsOf, DoNotOverlapAndStayInTheBed) {
  const Scene scene(GetParam().first, GetParam().second);
  const Mix mix(scene.bed, scene.domain.dimension);
  const auto stones = scene.build();
  ASSERT_GT(stones.size(), 100u);
  const auto bound = [&](const dem::NewParticle& p) { return mix.bound({p.shape, p.scale}); };
  for (std::size_t i = 0; i < stones.size(); ++i) {
    const double r = bound(stones[i]);
    EXPECT_GT(stones[i].position.z(), r);
    EXPECT_GE(stones[i].position.x() - r, scene.bed.x[0]);
    EXPECT_LE(stones[i].position.x() + r, scene.bed.x[1]);
    if (scene.domain.dimension == Dimension::plane) {
      EXPECT_EQ(stones[i].position.y(), 0);
    }
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_GT((stones[i].position - stones[j].position).norm(), r + bound(stones[j]));
  }
}

TEST_P(ColumnsOf, NumberStonesFromLeftToRight) {
  const auto stones = Scene(GetParam().first, GetParam().second).build();
  const bool plane = GetParam().first == Dimension::plane;
  const double cell =
      (plane ? 1 : 8) * 2 * 1.02 * 0.063 / 0.5;  // m, upper bound of a column's width
  for (std::size_t i = 0; i < stones.size(); ++i) {
    EXPECT_EQ(stones[i].id, static_cast<Id>(i));
    if (i > 0) {
      EXPECT_GT(stones[i].position.x(), stones[i - 1].position.x() - cell);
    }
  }
}

TEST_P(ColumnsOf, HoldTheRequiredSolidVolume) {
  const Scene scene(GetParam().first, GetParam().second);
  const Mix mix(scene.bed, scene.domain.dimension);
  const bool plane = scene.domain.dimension == Dimension::plane;
  double solid = 0;
  for (const auto& p : scene.build())
    solid += mix.templates()[static_cast<std::size_t>(p.shape)].volume *
             std::pow(p.scale, plane ? 2 : 3);
  const double wanted = 3 * scene.bed.height * (1 - scene.bed.porosity);
  EXPECT_NEAR(solid / wanted, 1, 0.01);  // draws are evenly distributed: half a large stone
  EXPECT_EQ(stones_of(par::Comm::self(), scene.bed, scene.domain).count,
            static_cast<std::int64_t>(scene.build().size()));
}

INSTANTIATE_TEST_SUITE_P(Kinds, ColumnsOf,
                         ::testing::Values(std::pair(Dimension::plane, StoneKind::disk),
                                           std::pair(Dimension::plane, StoneKind::pebbles),
                                           std::pair(Dimension::plane, StoneKind::clump),
                                           std::pair(Dimension::space, StoneKind::disk),
                                           std::pair(Dimension::space, StoneKind::polyhedra),
                                           std::pair(Dimension::space, StoneKind::compound),
                                           std::pair(Dimension::space, StoneKind::clump)));

// Spheres that stick at first contact fill more than a third of space.
TEST(Columns, InSpaceStonesAreDense) {
  Scene scene(Dimension::space, StoneKind::disk);
  scene.bed.sieve = {22.4, 63}, scene.bed.passing = {0, 100};
  scene.bed.height = 0.4;
  double top = 0;
  for (const auto& stone : scene.build()) top = std::max(top, stone.position.z());
  EXPECT_LT(top, 3 * scene.bed.height * (1 - scene.bed.porosity));
}

// For uniform rotations every axis of the body has a uniform direction: the means of R_ij and of
// R_ij R_kl are 0, those of R_ij^2 are 1/3, those of the fourth powers 1/5.
TEST(Columns, AttitudesAreUniformOverAllRotations) {
  Scene scene(Dimension::space, StoneKind::clump);
  scene.bed.height = 0.3;
  const auto stones = scene.build();
  ASSERT_GT(stones.size(), 5000U);
  Mat3 mean = Mat3::Zero(), square = Mat3::Zero(), fourth = Mat3::Zero();
  for (const dem::NewParticle& stone : stones) {
    const Mat3 turn = stone.attitude.normalized().toRotationMatrix();
    const Mat3 squared = turn.cwiseProduct(turn);
    mean += turn, square += squared, fourth += squared.cwiseProduct(squared);
  }
  const auto n = static_cast<double>(stones.size());
  // Four standard errors: those of R, R^2 and R^4 are sqrt(1/3), sqrt(4/45) and sqrt(16/225).
  EXPECT_LT((mean / n).cwiseAbs().maxCoeff(), 4 * std::sqrt(1.0 / 3 / n));
  EXPECT_LT((square / n - Mat3::Constant(1.0 / 3)).cwiseAbs().maxCoeff(),
            4 * std::sqrt(4.0 / 45 / n));
  EXPECT_LT((fourth / n - Mat3::Constant(1.0 / 5)).cwiseAbs().maxCoeff(),
            4 * std::sqrt(16.0 / 225 / n));
}

TEST(Columns, DependOnTheSeed) {
  Scene scene(Dimension::plane, StoneKind::pebbles);
  const auto first = scene.build(), again = scene.build();
  scene.bed.seed = 2;
  const auto other = scene.build();
  ASSERT_EQ(first.size(), again.size());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].position, again[i].position);
    EXPECT_EQ(first[i].attitude.coeffs(), again[i].attitude.coeffs());
    if (i < other.size() && first[i].position != other[i].position) ++moved;
  }
  EXPECT_GT(moved, first.size() / 2);
}

TEST(Columns, ShuffleIsAPermutation) {
  for (const std::uint64_t n : {1u, 2u, 7u, 1000u, 1025u}) {
    std::set<std::uint64_t> seen;
    for (std::uint64_t i = 0; i < n; ++i) seen.insert(shuffled(i, n, 42));
    EXPECT_EQ(seen.size(), n);
    EXPECT_LT(*seen.rbegin(), n);
  }
  std::size_t fixed = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) fixed += shuffled(i, 1000, 42) == i ? 1 : 0;
  EXPECT_LT(fixed, 10u);  // one on average
}

TEST(Columns, ABedNarrowerThanAStoneIsBadInput) {
  Scene scene(Dimension::plane, StoneKind::disk);
  scene.bed.x = {0, 0.05};
  EXPECT_THROW(scene.build(), InputError);
}

TEST(Walls, FaceTheBedAndLeaveOutPeriodicSides) {
  Scene scene(Dimension::space, StoneKind::disk);
  const auto all = walls(scene.domain, 2, 3, true);
  ASSERT_EQ(all.size(), 5u);
  const Vec3 middle(2.5, 0, 1);
  for (const Surface& wall : all) {
    EXPECT_EQ(wall.material, 3);
    for (const auto& t : wall.triangles) {
      const Vec3 &a = wall.position[static_cast<std::size_t>(t[0])],
                 &b = wall.position[static_cast<std::size_t>(t[1])],
                 &c = wall.position[static_cast<std::size_t>(t[2])];
      EXPECT_GT((b - a).cross(c - a).dot(middle - a), 0) << wall.name;
    }
  }
  EXPECT_EQ(all[0].name, "floor");
  EXPECT_EQ(all[0].position[0].z(), 0);
  EXPECT_EQ(all[1].position[0].x(), 1);
  EXPECT_EQ(all[2].position[0].x(), 4);
  scene.domain.periodic = {true, false, false};
  EXPECT_EQ(walls(scene.domain, 2, 3, false).size(), 2u);
  scene.domain.dimension = Dimension::plane;
  EXPECT_EQ(walls(scene.domain, 2, 3, false).size(), 0u);
}

// The division of the floor is only for speed. Balls of 1 to 20 mm on a floor of 0.3 x 0.2 m.
TEST(Heap, HeightsDoNotDependOnCells) {
  std::vector<Heap> heaps;
  for (const std::int64_t cells : {1, 2, 13, 64}) heaps.emplace_back(Vec3(0.3, 0.2, 0), cells);
  double highest = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const double r = 1e-3 * std::pow(20.0, uniform(1, 3 * i));
    const double x = r + uniform(1, 3 * i + 1) * (0.3 - 2 * r);
    const double y = r + uniform(1, 3 * i + 2) * (0.2 - 2 * r);
    const double z = heaps.front().height_on(x, y, r, std::numeric_limits<double>::infinity());
    for (const Heap& heap : heaps)
      ASSERT_EQ(heap.height_on(x, y, r, std::numeric_limits<double>::infinity()), z);
    for (const Heap& heap : heaps) ASSERT_GE(heap.height_on(x, y, r, 0.5 * z), 0.5 * z);
    for (Heap& heap : heaps) heap.add({.centre = {x, y, z}, .radius = r});
    highest = std::max(highest, z);
  }
  EXPECT_GT(highest, 0.1);
}

}  // namespace
}  // namespace trackbed::bed::columns_test
