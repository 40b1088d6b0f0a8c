// Rigid sleepers against motions known in closed form.
#include "trackbed/track/sleepers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace trackbed::track::sleepers_test {
namespace {

constexpr double rounding = 1e-12;  // relative, sums over up to 1e4 steps stay below
constexpr double g = 9.81;

SleeperParameters one_sleeper(std::vector<std::string> free) {
  SleeperParameters p;
  p.count = 1;
  p.free = std::move(free);
  return p;
}

// Node forces for the next window from the positions of the nodes at its start.
using Force = std::function<Vec3(std::size_t node, const Vec3& place)>;
void run(Sleepers& sleepers, double dt, int windows, const Force& force, double gravity) {
  const std::vector<double> seat(sleepers.count(), 0.0);
  for (int k = 0; k < windows; ++k) {
    std::vector<std::vector<Vec3>> lists;
    for (const Surface& surface : sleepers.surfaces()) {
      auto& list = lists.emplace_back();
      for (std::size_t n = 0; n < surface.nodes(); ++n)
        list.push_back(force(n, surface.position[n] + surface.motion[n]));
    }
    const std::vector<std::span<const Vec3>> spans(lists.begin(), lists.end());
    sleepers.advance(dt, seat, spans, gravity);
  }
}
Vec3 nothing(std::size_t, const Vec3&) { return Vec3::Zero(); }

TEST(Sleepers, SurfaceIsClosedWithOutwardNormals) {
  for (const double bevel : {0.0, 0.04}) {
    SleeperParameters p = one_sleeper({"z"});
    p.bevel = bevel;
    RigidSleepers sleepers(p, Dimension::space, 1, 3);
    sleepers.place(0.5);
    const Surface& surface = sleepers.surfaces()[0];
    EXPECT_EQ(surface.triangles.size(), bevel > 0 ? 20u : 12u);
    EXPECT_EQ(surface.material, 3);
    // Divergence theorem: the enclosed volume is correct only if all normals point outwards.
    double volume = 0, low = 1e9, high = -1e9;
    Vec3 area = Vec3::Zero();
    for (const auto& t : surface.triangles) {
      const Vec3 &a = surface.position[static_cast<std::size_t>(t[0])],
                 &b = surface.position[static_cast<std::size_t>(t[1])],
                 &c = surface.position[static_cast<std::size_t>(t[2])];
      volume += a.dot(b.cross(c)) / 6;
      area += (b - a).cross(c - a) / 2;
    }
    for (const Vec3& x : surface.position) low = std::min(low, x.z()), high = std::max(high, x.z());
    const double expected = (0.29 * 0.22 - bevel * bevel) * 1.3;
    EXPECT_NEAR(volume, expected, expected * rounding);
    EXPECT_NEAR(sleepers.mass(), expected * p.density, expected * p.density * rounding);
    EXPECT_LT(area.norm(), rounding);
    EXPECT_NEAR(low, 0.5, rounding);
    EXPECT_NEAR(high, 0.72, rounding);
  }
}

TEST(Sleepers, PlaneModelTakesItsThickness) {
  RigidSleepers sleepers(one_sleeper({"z"}), Dimension::plane, 0.4, 0);
  EXPECT_NEAR(sleepers.mass(), 0.29 * 0.22 * 0.4 * 2441, 62.3 * rounding);
  for (const Vec3& x : sleepers.surfaces()[0].position) EXPECT_NEAR(std::abs(x.y()), 0.2, rounding);
}

TEST(Sleepers, FreeFallIsExact) {
  RigidSleepers sleepers(one_sleeper({"x", "z", "ry"}), Dimension::plane, 1, 0);
  sleepers.place(1);
  run(sleepers, 1e-3, 400, nothing, g);
  const double t = 0.4;
  EXPECT_NEAR(sleepers.state(0).displacement.z(), -g * t * t / 2, rounding);
  EXPECT_NEAR(sleepers.state(0).acceleration.z(), -g, g * rounding);
  EXPECT_EQ(sleepers.state(0).displacement.x(), 0);
  const Surface& surface = sleepers.surfaces()[0];
  double low = 1e9;
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    low = std::min(low, (surface.position[n] + surface.motion[n]).z());
  EXPECT_NEAR(low, 1 - g * t * t / 2, rounding);
}

TEST(Sleepers, SeatForceActsDownwards) {
  RigidSleepers sleepers(one_sleeper({"z"}), Dimension::space, 1, 0);
  sleepers.place(0);
  const std::vector<double> seat{sleepers.mass() * 2};
  sleepers.advance(1e-3, seat, {}, 0);
  EXPECT_NEAR(sleepers.state(0).acceleration.z(), -2, 2 * rounding);
}

TEST(Sleepers, CoupleSpinsAboutTheLateralAxis) {
  // Moment 100 Nm on I = m (w^2 + h^2)/12. Follower forces keep the moment constant, so that the
  // angle is M t^2 / 2I; pairs of forces on two nodes of each end have no resultant.
  RigidSleepers sleepers(one_sleeper({"x", "z", "ry"}), Dimension::plane, 1.3, 0);
  sleepers.place(0);
  const double inertia = sleepers.mass() * (0.29 * 0.29 + 0.22 * 0.22) / 12, moment = 100;
  const auto couple = [&](std::size_t n, const Vec3&) {
    const double angle = sleepers.state(0).rotation.y();
    const Vec3 up(std::sin(angle), 0, std::cos(angle));
    const bool right = n % 4 == 1 || n % 4 == 2;               // profile corners at +x
    return Vec3((right ? -1 : 1) * moment / (4 * 0.29) * up);  // up on the left turns z into x: +y
  };
  run(sleepers, 1e-4, 200, couple, 0);
  const double t = 0.02, expected = moment * t * t / (2 * inertia);
  constexpr double arm = 1e-4;  // arms of mid-window against forces of its end: angle per window
  EXPECT_NEAR(sleepers.state(0).rotation.y(), expected, expected * arm);
  EXPECT_NEAR(sleepers.kinetic(), moment * expected,
              moment * expected * 0.02);  // mid-window: 0.5 %
  EXPECT_LT(sleepers.state(0).displacement.norm(), rounding);
}

// About a fixed centre a node moves through the angle w dt along a chord of 2 sin(w dt / 2) times
// its arm, perpendicular to its arm at mid-window. So the work of the forces on the motion of the
// surface gives their torque exactly; arms at the window's start or end have errors of order w dt.
TEST(Sleepers, TorqueDoesTheWorkOfTheNodesInTheLastWindow) {
  RigidSleepers sleepers(one_sleeper({"ry"}), Dimension::plane, 1.3, 0);
  sleepers.place(0);
  const double inertia = sleepers.mass() * (0.29 * 0.29 + 0.22 * 0.22) / 12;
  const std::vector<double> seat{0.0};
  const Surface& surface = sleepers.surfaces()[0];
  std::vector<Vec3> forces;
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    forces.emplace_back(2e3 + 600 * static_cast<double>(n), 0, 1400 - 500 * static_cast<double>(n));
  double last = 0, turned = 0;                                 // s, rad
  for (const double dt : {0.01, 0.01, 0.006, 0.012, 0.009}) {  // s
    const double spin = sleepers.state(0).spin.y(), angle = spin * last;
    double work = 0;
    for (std::size_t n = 0; n < surface.nodes(); ++n) work += forces[n].dot(surface.motion[n]);
    sleepers.advance(dt, seat, {forces}, 0);
    if (last > 0) {
      const double kick = work / (2 * std::sin(angle / 2)) * (last + dt) / 2 / inertia;
      // The chords are differences of positions near 1 m, 1e-3 m long: three digits are lost.
      EXPECT_NEAR(sleepers.state(0).spin.y() - spin, kick, 1e3 * rounding);
      turned = std::max(turned, std::abs(angle));
    }
    last = dt;
  }
  EXPECT_GT(turned, 0.05);  // rad in one window: the arms did change
}

TEST(Sleepers, BodyFrameMotionKeepsTheShape) {
  RigidSleepers sleepers(one_sleeper({"x", "y", "z", "rx", "ry", "rz"}), Dimension::space, 1, 0);
  sleepers.place(0);
  run(
      sleepers, 1e-3, 300,
      [](std::size_t n, const Vec3&) { return n == 1 ? Vec3(300, 700, -200) : Vec3(Vec3::Zero()); },
      0);
  const Surface& surface = sleepers.surfaces()[0];
  EXPECT_GT(sleepers.state(0).rotation.norm(), 0.5);  // rad: it did turn
  const auto end = [&](std::size_t n) { return Vec3(surface.position[n] + surface.motion[n]); };
  EXPECT_NEAR((end(0) - end(6)).norm(), Vec3(0.29, 1.3, 0.22).norm(), rounding);
  EXPECT_NEAR((end(0) - end(1)).norm(), 0.29, rounding);
}

TEST(Sleepers, FrozenDirectionsStay) {
  RigidSleepers sleepers(one_sleeper({"z"}), Dimension::space, 1, 0);
  sleepers.place(0);
  run(
      sleepers, 1e-3, 50,
      [](std::size_t n, const Vec3&) { return n == 0 ? Vec3(500, 400, 300) : Vec3(Vec3::Zero()); },
      g);
  const SleeperState state = sleepers.state(0);
  EXPECT_EQ(state.displacement.x(), 0);
  EXPECT_EQ(state.displacement.y(), 0);
  EXPECT_EQ(state.rotation, Vec3(Vec3::Zero()));
  EXPECT_NE(state.displacement.z(), 0);
}

// Prescribed displacements are independent of forces; after release at rest, free fall starts
// there.
TEST(Sleepers, CarriedOnesFollowThePrescribedMotionAndFallFromRest) {
  RigidSleepers sleepers(one_sleeper({"z", "ry"}), Dimension::space, 1, 0);
  sleepers.place(0);
  run(sleepers, 1e-3, 10, nothing, g);  // falls
  const double fallen = sleepers.state(0).displacement.z();
  const std::vector<Vec3> forces(sleepers.surfaces()[0].nodes(), Vec3(10, 0, 50));
  for (int k = 0; k < 5; ++k) sleepers.carry(1e-3, 2e-3, {forces});
  EXPECT_NEAR(sleepers.state(0).displacement.z() - fallen, 0.01, rounding);
  EXPECT_NEAR(sleepers.velocity_now(0).z(), 2, rounding);
  EXPECT_EQ(sleepers.state(0).rotation, Vec3(Vec3::Zero()));
  EXPECT_NEAR(sleepers.reaction(0).z(), 50 * static_cast<double>(forces.size()), 1e-9);
  sleepers.carry(1e-3, 0, {forces});
  run(sleepers, 1e-3, 1, nothing, g);
  EXPECT_NEAR(sleepers.state(0).displacement.z() - fallen, 0.01 - g * 1e-6, rounding);
}

// Bounce and pitch on springs below the four lower corners, released at rest; returns z and angle.
Eigen::Vector2d on_springs(int windows) {
  constexpr double stiffness = 2e7, end = 0.02;  // N/m each, s
  RigidSleepers sleepers(one_sleeper({"z", "ry"}), Dimension::space, 1, 0);
  sleepers.place(0);
  run(
      sleepers, end / windows, windows,
      [&](std::size_t n, const Vec3& place) {
        const double softer = n % 4 == 0 ? 0.5 : 1;  // left corners: couples bounce and pitch
        return n % 4 < 2 ? Vec3(0, 0, -softer * stiffness * place.z()) : Vec3(Vec3::Zero());
      },
      g);
  return {sleepers.state(0).displacement.z(), sleepers.state(0).rotation.y()};
}

TEST(Sleepers, OrderTwoOnSprings) {
  const Eigen::Vector2d exact = on_springs(12800);
  const double coarse = (on_springs(100) - exact).norm(), fine = (on_springs(200) - exact).norm();
  const double finest = (on_springs(400) - exact).norm();
  // Order 2 between levels; the arms at mid-window and the reference cause deviations of up to 0.1.
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.1);
  EXPECT_NEAR(std::log2(fine / finest), 2, 0.1);
}

TEST(Sleepers, RepeatedRunsAreBitwiseIdentical) { EXPECT_EQ(on_springs(300), on_springs(300)); }

TEST(Sleepers, OverlapsFollowTheBox) {
  RigidSleepers sleepers(SleeperParameters{}, Dimension::space, 1, 0);
  sleepers.place(0.35);
  const double face = 0.6 + 0.145;  // m, right face of the first sleeper
  EXPECT_TRUE(sleepers.overlaps({face + 0.019, 0, 0.4}, 0.02));
  EXPECT_FALSE(sleepers.overlaps({face + 0.021, 0, 0.4}, 0.02));
  EXPECT_TRUE(sleepers.overlaps({0.6 + 8 * 0.6, 0, 0.331}, 0.02));
  EXPECT_FALSE(sleepers.overlaps({0.6 + 8 * 0.6, 0, 0.329}, 0.02));
  EXPECT_FALSE(sleepers.overlaps({face + 0.015, 0, 0.335}, 0.02));  // corner: 0.0212 m away
  EXPECT_FALSE(sleepers.overlaps({0.6, 0.68, 0.4}, 0.02));
}

TEST(Sleepers, TroubleNamesTheSleeper) {
  RigidSleepers sleepers(one_sleeper({"z"}), Dimension::space, 1, 0);
  sleepers.place(0);
  EXPECT_EQ(sleepers.trouble(), "");
  const std::vector<double> seat{std::nan("")};
  sleepers.advance(1e-3, seat, {}, g);
  EXPECT_NE(sleepers.trouble().find("sleeper placed at x = 0.6 m"), std::string::npos);
}

}  // namespace
}  // namespace trackbed::track::sleepers_test
