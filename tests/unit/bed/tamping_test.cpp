// Tines: their positions during the cycle, and that they are closed boxes.
#include "trackbed/bed/tamping.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace trackbed::bed::tamping_test {
namespace {

constexpr double top = 0.5, underside = 0.32;  // m
constexpr double rounding = 1e-12;             // m

TampingParameters parameters() {
  TampingParameters p;
  p.y = {-0.2, 0.3};
  p.amplitude = 0, p.insertion = 0.3;
  return p;
}

Tines tines(const TampingParameters& p, Dimension dimension = Dimension::space) {
  Tines made(p, {.x = {0.3, 0.9}, .width = 0.29}, dimension, 1.3, 0);
  made.set_heights(top, underside);
  return made;
}

struct Extent {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
};

// Extent of the first tine of a side.
Extent extent(const Surface& side) {
  Extent all;
  for (std::size_t n = 0; n < 8; ++n)
    all.low = all.low.cwiseMin(side.position[n]), all.high = all.high.cwiseMax(side.position[n]);
  return all;
}

// The same force on every node of a side, N.
struct NodeForces {
  Vec3 left = Vec3::Zero(), right = Vec3::Zero();
};

// Advances in windows of 1 ms, from `begin` to `end` ms.
constexpr double dt = 1e-3;  // s
void run(Tines& t, int begin, int end, const NodeForces& forces = {}) {
  const std::vector<Vec3> left(t.surfaces()[0].nodes(), forces.left);
  const std::vector<Vec3> right(t.surfaces()[1].nodes(), forces.right);
  for (int k = begin; k < end; ++k) t.advance(k * dt, dt, {left, right});
  t.show_at_rest(end * dt);
}

TEST(Tines, GoInSqueezeAndComeOut) {
  const TampingParameters p = parameters();
  Tines t = tines(p);
  const double face = 0.3 - 0.29 / 2, open = face - p.gap, closed = open + p.closing;
  const double up = top + 0.05, deep = underside - p.depth;
  struct At {
    int time;  // ms
    double inner, tip;
  };
  int now = 0;
  for (const At& at :
       {At{0, open, up}, At{150, open, (up + deep) / 2}, At{300, open, deep},
        At{700, (open + closed) / 2, deep}, At{1100, closed, deep},
        At{1250, (open + closed) / 2, (up + deep) / 2}, At{1400, open, up}, At{1700, open, deep}}) {
    run(t, std::exchange(now, at.time), at.time);
    EXPECT_NEAR(extent(t.surfaces()[0]).high.x(), at.inner, rounding) << at.time;
    EXPECT_NEAR(extent(t.surfaces()[1]).low.x(), 0.6 - at.inner, rounding) << at.time;
    EXPECT_NEAR(extent(t.surfaces()[0]).low.z(), at.tip, rounding) << at.time;
    EXPECT_GT(extent(t.surfaces()[0]).high.z(), top);  // the upper ends remain out of the bed
  }
  EXPECT_NEAR(t.displacement("tines.left").z(), deep - up, rounding);
}

TEST(Tines, LiftTheSleepersOnceWithTheFirstInsertion) {
  const TampingParameters p = parameters();
  const Tines t = tines(p);
  EXPECT_EQ(t.lift(0), 0);
  EXPECT_NEAR(t.lift(p.insertion / 2), p.lift / 2, rounding);
  EXPECT_EQ(t.lift(p.insertion), p.lift);
  EXPECT_EQ(t.lift(1.5 * p.cycle()), p.lift);
}

// Half the force halves the displacement, the whole force stops it, a larger one reverses it; each
// arm alone, and the frame by both. Two tines of 8 nodes per arm.
TEST(Tines, YieldInProportion) {
  const TampingParameters p = parameters();
  const double all = 2 * p.force / 16, deep = underside - p.depth - (top + 0.05);
  Tines t = tines(p);
  run(t, 0, 300, {.left = {0, 0, all / 2}, .right = {0, 0, all / 2}});
  EXPECT_NEAR(t.displacement("tines.right").z(), deep / 2, rounding);
  run(t, 300, 1100, {.left = {-all / 4, 0, 0}, .right = {all, 0, 0}});
  EXPECT_NEAR(t.displacement("tines.left").x(), 0.75 * p.closing, rounding);
  EXPECT_NEAR(t.displacement("tines.right").x(), 0, rounding);
  run(t, 1100, 1400);
  EXPECT_NEAR(t.displacement("tines.left").norm(), 0, rounding);
  run(t, 1400, 1700, {.left = {0, 0, 3 * all}});
  EXPECT_NEAR(t.displacement("tines.left").z(), -deep / 2, rounding);
}

// A window ends where the next one begins; both sides move towards each other.
TEST(Tines, MoveFromWindowToWindow) {
  TampingParameters p = parameters();
  p.amplitude = 5e-3;
  Tines t = tines(p);
  const std::vector<Vec3> none(t.surfaces()[0].nodes(), Vec3::Zero());
  double largest = 0;
  std::vector<Vec3> end = t.surfaces()[0].position;
  for (int k = 0; k < 1400; ++k) {
    t.advance(k * dt, dt, {none, none});
    for (std::size_t n = 0; n < end.size(); ++n) {
      EXPECT_LT((end[n] - t.surfaces()[0].position[n]).norm(), rounding);
      end[n] += t.surfaces()[0].motion[n];
    }
    const Vec3 left = t.surfaces()[0].motion[0], right = t.surfaces()[1].motion[0];
    EXPECT_NEAR(left.x(), -right.x(), rounding);
    EXPECT_EQ(left.z(), right.z());
    largest = std::max(largest, std::abs(left.x()));
  }
  // Largest speeds of the vibration, 2 pi f A, and of the opening; 1 %: they rarely coincide.
  const double pi = std::numbers::pi;
  const double fastest = 2 * pi * p.frequency * p.amplitude + pi / 2 * p.closing / p.withdrawal;
  EXPECT_NEAR(largest, fastest * dt, 0.01 * fastest * dt);
}

TEST(Tines, AreClosedBoxesWithNormalsOutwards) {
  const TampingParameters p = parameters();
  Tines t = tines(p);
  for (const Surface& side : t.surfaces()) {
    ASSERT_EQ(side.nodes(), 2u * 2u * 8u);
    double volume = 0;
    Vec3 area = Vec3::Zero();
    for (const auto& [a, b, c] : side.triangles) {
      const auto at = [&](std::int32_t n) { return side.position[static_cast<std::size_t>(n)]; };
      volume += at(a).dot(at(b).cross(at(c))) / 6;
      area += (at(b) - at(a)).cross(at(c) - at(a));
    }
    const Extent one = extent(side);
    EXPECT_NEAR(volume, 4 * (one.high - one.low).prod(), rounding);
    EXPECT_LT(area.norm(), rounding);
    EXPECT_NEAR(one.high.x() - one.low.x(), p.thickness, rounding);
    EXPECT_NEAR(one.high.y() - one.low.y(), p.width, rounding);
  }
}

TEST(Tines, ExtendAcrossAPlaneModel) {
  Tines t = tines(parameters(), Dimension::plane);
  ASSERT_EQ(t.surfaces()[0].nodes(), 2u * 8u);
  EXPECT_NEAR(extent(t.surfaces()[0]).high.y(), 0.65, rounding);
}

}  // namespace
}  // namespace trackbed::bed::tamping_test
