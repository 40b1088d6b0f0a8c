// Solid bodies: results that are exact for any mesh, and checkpoints.
#include "trackbed/fem/bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/bodies/bodies_system.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::fem::bodies_test {
namespace {

constexpr double g = 9.81;
constexpr double rounding = 1e-7;  // relative, of solves of stiff bodies in long steps
const Elastic concrete{.young = 37e9, .poisson = 0.2, .density = 2500};

Body bar(const std::string& name = "bar", double z = 0) {
  return {.name = name,
          .low = {-0.15, -0.5, z},
          .high = {0.15, 0.5, z + 0.2},
          .elements = {3, 8, 2},
          .solid = concrete,
          .touched = true};
}

Bodies one(double alpha = -0.1) {
  BodiesParameters p;
  p.bodies = {bar()};
  p.alpha = alpha;
  Bodies bodies(p);
  bodies.place({1, 0, 0.3});
  return bodies;
}

// Two bars, the upper one on a pad in the middle of the lower one.
Bodies stack(const Vec3& stiffness, const Vec3& damping = Vec3::Zero()) {
  BodiesParameters p;
  p.bodies = {bar("lower"), bar("upper", 0.2)};
  p.pads = {{.below = 0,
             .above = 1,
             .patch = {.x = {-0.1, 0.1}, .y = {-0.1, 0.1}},
             .stiffness = stiffness,
             .damping = damping}};
  return Bodies(p);
}

TEST(Bodies, SurfaceIsClosedAndPointsOutwards) {
  Bodies bodies = one();
  const Surface& surface = bodies.surfaces().at(0);
  EXPECT_EQ(surface.name, "bar");
  EXPECT_EQ(surface.triangles.size(), 2u * 2 * (3 * 8 + 8 * 2 + 2 * 3));
  EXPECT_EQ(surface.nodes(), 4u * 9 * 3 - 2u * 7 * 1);
  double volume = 0, low = 1e9;
  Vec3 area = Vec3::Zero();
  for (const auto& t : surface.triangles) {
    const Vec3 &a = surface.position[static_cast<std::size_t>(t[0])],
               &b = surface.position[static_cast<std::size_t>(t[1])],
               &c = surface.position[static_cast<std::size_t>(t[2])];
    volume += a.dot(b.cross(c)) / 6;
    area += (b - a).cross(c - a) / 2;
    low = std::min({low, a.z(), b.z(), c.z()});
  }
  EXPECT_NEAR(volume, 0.3 * 1.0 * 0.2, rounding);
  EXPECT_LT(area.norm(), rounding);
  EXPECT_NEAR(low, 0.3, rounding);
  EXPECT_NEAR(bodies.mass(0), 2500 * 0.06, rounding);
}

TEST(Bodies, FreeFallIsExactAndWithoutStress) {
  Bodies bodies = one();
  for (int k = 0; k < 200; ++k) bodies.advance(1e-3, g, {}, {});
  const double t = 0.2;
  const BodyMotion now = bodies.motion(0);
  EXPECT_NEAR(now.displacement.z(), -g * t * t / 2, rounding);
  EXPECT_NEAR(now.velocity.z(), -g * t, rounding);
  EXPECT_NEAR(now.acceleration.z(), -g, rounding * g);
  EXPECT_LT(now.rotation.norm(), rounding);
  EXPECT_LT(std::abs(bodies.stress(0, {0, 0, 0.1})[1]), 1.0);  // Pa: 1e-11 of Young's modulus
  const Surface& surface = bodies.surfaces().at(0);
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    EXPECT_NEAR(surface.motion[n].z(), -g * (t * t - 0.199 * 0.199) / 2, rounding * t);
}

TEST(Bodies, ForcesMakeMomentumAndSpin) {
  Bodies bodies = one();
  const Vec3 force(30, -20, 50);
  const Patch corner{.x = {0.1, 0.15}, .y = {0.4, 0.5}};
  const Bodies::PatchLoad push{bodies.over(0, Side::upper, corner), force};
  constexpr double dt = 1e-4;
  constexpr int steps = 50;
  for (int k = 0; k < steps; ++k) bodies.advance(dt, 0, std::span(&push, 1), {});
  const BodyMotion now = bodies.motion(0);
  EXPECT_LT((bodies.mass(0) * now.velocity - force * dt * steps).norm(),
            rounding * force.norm() * dt * steps);
  const Vec3 torque = Vec3(0.125, 0.45, 0.1).cross(force);
  const Vec3 inertia = bodies.mass(0) / 12 * Vec3(1 + 0.04, 0.04 + 0.09, 0.09 + 1);
  const Vec3 spin = (torque * dt * steps).cwiseQuotient(inertia);
  EXPECT_LT((now.spin - spin).norm(), rounding * spin.norm());
}

TEST(Bodies, SurfaceForcesActAsPointForces) {
  Bodies pushed = one(), pressed = one();
  const Bodies::PatchLoad push{pushed.over(0, Side::lower, {.x = {0, 0}, .y = {0.5, 0.5}}),
                               {0, 0, 40}};
  std::vector<Vec3> force(pressed.surfaces()[0].nodes(), Vec3::Zero());
  std::size_t found = 0;
  for (std::size_t n = 0; n < force.size(); ++n) {
    const Vec3 at = pressed.surfaces()[0].position[n] - Vec3(1, 0, 0.3);
    const bool at_middle = std::abs(at.x()) < 0.1 && std::abs(at.y() - 0.5) < 1e-9;
    if (!at_middle || std::abs(at.z()) > 1e-9) continue;
    force[n].z() = 20, ++found;  // the point is midway between two nodes
  }
  ASSERT_EQ(found, 2u);
  for (int k = 0; k < 20; ++k) {
    pushed.advance(1e-4, g, std::span(&push, 1), {});
    pressed.advance(1e-4, g, {}, {std::span<const Vec3>(force)});
  }
  EXPECT_LT((pushed.motion(0).rotation - pressed.motion(0).rotation).norm(),
            rounding * pushed.motion(0).rotation.norm());
  EXPECT_LT((pushed.motion(0).displacement - pressed.motion(0).displacement).norm(), 1e-15);
}

TEST(Bodies, WeightsOfAPatchHaveItsCentre) {
  const Bodies bodies = one();
  const Patch patch{.x = {-0.08, 0.02}, .y = {0.03, 0.4}};
  double sum = 0;
  for (const NodeWeight& one : bodies.over(0, Side::upper, patch)) sum += one.weight;
  EXPECT_NEAR(sum, 1, rounding);
  // In rotation about z a point moves by rotation x arm.
  Bodies turning = one();
  const Bodies::PatchLoad there{turning.over(0, Side::upper, {.x = {0.15, 0.15}, .y = {0, 0}}),
                                {0, 1e3, 0}};
  for (int k = 0; k < 10; ++k) turning.advance(1e-3, 0, std::span(&there, 1), {});
  const BodyMotion now = turning.motion(0);
  const Vec3 arm(-0.03, 0.215, 0.1);
  const Vec3 rigid = now.displacement + now.rotation.cross(arm);
  const Vec3 found = turning.displacement(turning.over(0, Side::upper, patch));
  constexpr double bends = 1e-2;  // of the motion: the bar is elastic
  EXPECT_LT((found - rigid).norm(), bends * rigid.norm());
}

TEST(Bodies, PadForcesOnBothBodiesAreOpposite) {
  Bodies bodies = stack({1e6, 2e6, 5e6}, {3e3, 3e3, 4e3});
  bodies.place(Vec3::Zero());
  const Bodies::PatchLoad push{bodies.over(1, Side::upper, {.x = {0.02, 0.1}, .y = {0.2, 0.3}}),
                               {100, 50, -200}};
  constexpr double dt = 1e-4;
  constexpr int steps = 300;
  for (int k = 0; k < steps; ++k) bodies.advance(dt, 0, std::span(&push, 1), {});
  const Vec3 momentum = bodies.mass(0) * (bodies.motion(0).velocity + bodies.motion(1).velocity);
  EXPECT_LT((momentum - push.force * dt * steps).norm(), rounding * momentum.norm());
  // Bossak's balance at the end of a step, with its alpha of -0.1: M (1.1 a' - 0.1 a) = F'.
  const Vec3 lower = bodies.motion(0).acceleration, upper = bodies.motion(1).acceleration;
  bodies.advance(dt, 0, std::span(&push, 1), {});
  const Vec3 on_upper = bodies.pad_force(0);
  const Vec3 off_lower = bodies.mass(0) * (1.1 * bodies.motion(0).acceleration - 0.1 * lower);
  const Vec3 of_upper = bodies.mass(1) * (1.1 * bodies.motion(1).acceleration - 0.1 * upper);
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(std::abs(on_upper[c]), 0.05 * std::abs(push.force[c])) << c;
    EXPECT_NEAR(off_lower[c], -on_upper[c], rounding * push.force.norm()) << c;
    EXPECT_NEAR(of_upper[c], push.force[c] + on_upper[c], rounding * push.force.norm()) << c;
  }
}

// In a rotation about its middle by 1 rad, in the theory of small displacements, a pad of k N/m
// stores half of k L^2/12; a common rotation of both bodies stores nothing.
TEST(Bodies, PadsResistRotationAsAUniformBedding) {
  const std::vector<BodyMesh> meshes = {{bar("lower"), 0}, {bar("upper", 0.2), 4 * 9 * 3}};
  const Vec3 stiffness(1e6, 2e6, 5e6);
  const Patch patch{.x = {-0.05, 0.12}, .y = {-0.3, 0.1}};
  BodiesParameters p;
  p.bodies = {meshes[0].body, meshes[1].body};
  p.pads = {{.below = 0, .above = 1, .patch = patch, .stiffness = stiffness}};
  BodiesSystem system(meshes, p);
  const Vec3 middle(0.035, -0.1, 0.2);
  const double along = 0.17 * 0.17 / 12, across = 0.4 * 0.4 / 12;
  const Vec3 expected(stiffness.z() * across, stiffness.z() * along,
                      stiffness.x() * across + stiffness.y() * along);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::int32_t n = 0; n < meshes[1].nodes(); ++n) {
      const std::int32_t node = meshes[1].first + n;
      system.put(node, Vec3::Unit(axis).cross(meshes[1].position(node) - middle),
                 system.displacement);
    }
    EXPECT_NEAR(2 * system.elastic(), expected[axis], rounding * expected[axis]) << axis;
  }
}

TEST(Bodies, FixedFacesDoNotMove) {
  BodiesParameters p;
  p.bodies = {bar()};
  p.held = {{.body = 0, .axis = 1, .low = true, .components = {true, true, true}}};
  Bodies bodies(p);
  bodies.place(Vec3::Zero());
  for (int k = 0; k < 20; ++k) bodies.advance(1e-3, g, {}, {});
  const NodeWeights held = bodies.over(0, Side::upper, {.x = {0, 0}, .y = {-0.5, -0.5}}),
                    end = bodies.over(0, Side::upper, {.x = {0, 0}, .y = {0.5, 0.5}});
  EXPECT_EQ(bodies.displacement(held).norm(), 0);
  EXPECT_LT(bodies.displacement(end).z(), 0);
}

// A cantilever under a static force at its end: M c / I in the middle of elements and at borders.
TEST(Bodies, BendingStressFollowsFromTheMomentAlsoAtBorders) {
  BodiesParameters p;
  p.bodies = {{.name = "cantilever",
               .low = {-0.1, 0, 0},
               .high = {0.1, 2.6, 0.2},
               .elements = {2, 26, 2},
               .solid = {.young = 37e9, .poisson = 0, .density = 2500}}};
  p.held = {{.body = 0, .axis = 1, .low = true, .components = {true, true, true}}};
  Bodies bodies(p);
  bodies.place(Vec3::Zero());
  const double force = -5e3, length = 2.6, inertia = std::pow(0.2, 4) / 12;
  const Bodies::PatchLoad push{
      bodies.over(0, Side::upper, {.x = {-0.1, 0.1}, .y = {length, length}}), {0, 0, force}};
  for (int k = 0; k < 200; ++k) bodies.advance(1, 0, std::span(&push, 1), {});
  for (const double y : {0.65, 0.7, 1.3, 1.35, 1.9, 2.0}) {
    const double exact = force * (length - y) * 0.1 / inertia;
    for (const double x : {0.0, 0.05})
      EXPECT_NEAR(bodies.stress(0, {x, y, 0})[1], exact, 2e-3 * std::abs(exact)) << x << ' ' << y;
    EXPECT_NEAR(bodies.stress(0, {0, y, 0.1})[1], 0, 2e-3 * std::abs(exact)) << y;
  }
}

TEST(Bodies, StoppedAndResumedIsBitwiseIdentical) {
  const par::Comm world = par::Comm::world();
  Bodies straight = one(), first = one(), second = one();
  const Bodies::PatchLoad push{straight.over(0, Side::upper, {.x = {0, 0.1}, .y = {0.2, 0.4}}),
                               {100, 200, -5e3}};
  const auto go = [&](Bodies& bodies, int steps) {
    for (int k = 0; k < steps; ++k) bodies.advance(2e-5, g, std::span(&push, 1), {});
  };
  go(straight, 40), go(first, 15);
  const io::Scratch scratch("bodies");
  {
    io::File file(world, scratch / "solids.h5", io::Mode::create);
    io::Archive::writer(world, file).part("solids", first);
    file.close();
  }
  const io::File file(world, scratch / "solids.h5", io::Mode::read);
  io::Archive::reader(file).part("solids", second);
  first.show_at_rest();
  EXPECT_EQ(second.surfaces()[0].position, first.surfaces()[0].position);
  go(second, 25);
  EXPECT_EQ(straight.motion(0).displacement, second.motion(0).displacement);
  EXPECT_EQ(straight.motion(0).spin, second.motion(0).spin);
  EXPECT_EQ(straight.stress(0, {0, 0, 0}), second.stress(0, {0, 0, 0}));
}

TEST(Bodies, TimeStepMayChangeWithinARun) {
  Bodies bodies = one();
  for (const double dt : {1e-3, 5e-4, 2e-3}) bodies.advance(dt, g, {}, {});
  EXPECT_NEAR(bodies.motion(0).displacement.z(), -g * 3.5e-3 * 3.5e-3 / 2, 1e-15);
}

TEST(Bodies, TroubleNamesTheBody) {
  Bodies bodies = one();
  EXPECT_EQ(bodies.trouble(), "");
  const Bodies::PatchLoad push{bodies.over(0, Side::upper, {.x = {0.15, 0.15}, .y = {0.5, 0.5}}),
                               {0, 0, 1e6}};
  for (int k = 0; k < 10; ++k) bodies.advance(1e-3, 0, std::span(&push, 1), {});
  EXPECT_NE(bodies.trouble().find("bar has turned by"), std::string::npos) << bodies.trouble();
}

TEST(Bodies, FieldsAreOnTheFirstRank) {
  const par::Comm world = par::Comm::world();
  Bodies bodies = one();
  bodies.advance(1e-3, g, {}, {});
  const io::Grid grid = bodies.fields(world);
  EXPECT_EQ(grid.points.size(), world.root() ? 4u * 9 * 3 : 0u);
  EXPECT_EQ(grid.cells.size(), world.root() ? 8u * 3 * 8 * 2 : 0u);
  ASSERT_EQ(grid.cell_data.size(), 3u);
  EXPECT_EQ(grid.cell_data[0].values.size(), world.root() ? 6u * 48 : 0u);
}

// A force also displaces other places, by as much as a force there displaces its own (Betti).
TEST(Bodies, CompliancesAreReciprocal) {
  Bodies bodies = one();
  constexpr double dt = 2e-4, force = 3e3;
  const NodeWeights at = bodies.over(0, Side::upper, {.x = {0, 0.1}, .y = {0.1, 0.3}}),
                    there = bodies.over(0, Side::upper, {.x = {0, 0.2}, .y = {0, 0.1}});
  const Bodies::PatchLoad push{at, {0, 0, force}};
  bodies.advance(dt, g, {}, {});
  const double rate = bodies.velocity(there).z();
  bodies.add_loads(std::span(&push, 1));
  const double gained = bodies.velocity(there).z() - rate, wanted = bodies.mobility(dt, there, at);
  EXPECT_NEAR(gained, force * wanted, rounding * std::abs(gained));
  EXPECT_NEAR(bodies.mobility(dt, at, there), wanted, rounding * std::abs(wanted));
  EXPECT_LT(std::abs(wanted), 0.9 * bodies.mobility(dt, at));
}

// A force applied after a step acts as one applied in it, with the predicted displacement.
TEST(Bodies, ForcesAfterAStepActAtItsEnd) {
  Bodies before = one(), after = one(), without = one();
  constexpr double dt = 2e-4, force = 3e3;
  const NodeWeights at = after.over(0, Side::upper, {.x = {0, 0.1}, .y = {0.1, 0.3}});
  const Bodies::PatchLoad push{at, {0, 0, force}};
  for (Bodies* bodies : {&before, &after, &without}) bodies->advance(dt, g, {}, {});
  for (int n = 0; n < 20; ++n) {
    before.advance(dt, g, std::span(&push, 1), {});
    after.advance(dt, g, {}, {});
    if (n == 0) without.advance(dt, g, {}, {});
    const double rate = after.velocity(at).z();
    after.add_loads(std::span(&push, 1));
    const double gained = after.velocity(at).z() - rate;
    EXPECT_NEAR(gained, force * after.mobility(dt, at), rounding * gained);
    if (n == 0) {
      EXPECT_NEAR(after.trapezoidal(dt, at).z() - without.trapezoidal(dt, at).z(), dt / 2 * gained,
                  rounding * dt * gained);
    }
  }
  const double way = before.displacement(at).z();
  EXPECT_NEAR(after.displacement(at).z(), way, rounding * std::abs(way));
  for (std::size_t k = 0; k < after.surfaces()[0].nodes(); ++k)
    EXPECT_LT((after.surfaces()[0].motion[k] - before.surfaces()[0].motion[k]).norm(),
              rounding * std::abs(way));
}

TEST(Bodies, TheTrapezoidalDisplacementFollowsTheVelocities) {
  Bodies bodies = one();
  constexpr double dt = 1e-4;
  const NodeWeights at = bodies.over(0, Side::upper, {.x = {0, 0.1}, .y = {0.1, 0.3}});
  const Bodies::PatchLoad push{at, {0, 0, 5e3}};
  bodies.advance(dt, g, {}, {});
  double place = bodies.trapezoidal(dt, at).z(), rate = bodies.velocity(at).z(), off = 0;
  for (int n = 0; n < 50; ++n) {
    bodies.advance(dt, g, std::span(&push, 1), {});
    place += dt / 2 * (rate + bodies.velocity(at).z()), rate = bodies.velocity(at).z();
    off = std::max(off, std::abs(bodies.displacement(at).z() - place));
    EXPECT_NEAR(bodies.trapezoidal(dt, at).z(), place, 1e-13);
  }
  EXPECT_GT(off, 1e-11);  // the displacement itself does not
}

}  // namespace
}  // namespace trackbed::fem::bodies_test
