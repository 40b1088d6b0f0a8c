// Held particles keep velocity and spin for any forces, and act on others as if they were
// infinitely heavy; the same on any number of ranks. Their motion is known exactly, and with it the
// path of friction.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene.hpp"

namespace trackbed::held_test {
namespace {

constexpr double r = 0.01;  // m

dem::Particles scene_of(const par::Comm& comm, const std::vector<dem::NewParticle>& all,
                        const dem::ContactLaw& law) {
  dem::Particles particles(comm, test::one_material(law), {},
                           test::box({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}));
  particles.add_template(test::clump());
  particles.add_template(test::sphere());
  particles.add(test::mine(comm, all));
  return particles;
}

std::map<Id, dem::ParticleView> views_of(const dem::Particles& particles) {
  std::map<Id, dem::ParticleView> views;
  for (std::size_t i = 0; i < particles.size(); ++i) views[particles[i].id] = particles[i];
  return views;
}

dem::ContactLaw damped() {
  dem::ContactLaw law;
  law.k_n = 1e5, law.k_s = 0, law.friction = 0;
  law.zeta_n = 0.2, law.attraction = true;
  return law;
}

dem::NewParticle sphere_at(Id id, const Vec3& position, const Vec3& velocity) {
  dem::NewParticle p;
  p.id = id, p.shape = 1, p.scale = r, p.position = position, p.velocity = velocity;
  return p;
}

// A driven clump among falling spheres rotates about an axis that is not a principal one.
TEST(Held, KeepsVelocityAndSpinUnderForces) {
  const Vec3 velocity(0.1, -0.05, 0.02), spin(20, -10, 30);
  dem::NewParticle driven;
  driven.id = 0, driven.scale = 2 * r, driven.velocity = velocity, driven.spin = spin;
  driven.attitude = Quat(1, 0.3, -0.2, 0.5).normalized();
  driven.held = true;
  std::vector<dem::NewParticle> all{driven};
  for (Id k = 1; k <= 4; ++k)
    all.push_back(sphere_at(k, {0.025 * static_cast<double>(k) - 0.0625, 0.002, 0.06}, {0, 0, -1}));
  const auto run = [&](const par::Comm& comm) {
    dem::Particles particles = scene_of(comm, all, damped());
    bool touched = false;
    for (int window = 0; window < 200; ++window) {
      particles.advance(5e-4, 10);
      EXPECT_EQ(particles.trouble(), "");
      touched = touched || particles.totals().contacts > 0;
    }
    EXPECT_TRUE(touched);
    return particles;
  };
  const dem::Particles one = run(par::Comm::self()), all_ranks = run(par::Comm::world());
  EXPECT_EQ(one.state_hash(), all_ranks.state_hash());
  const dem::ParticleView p = views_of(one).at(0);
  const double time = 0.1, turn = time * spin.norm();
  EXPECT_TRUE(p.held);
  EXPECT_LT((p.velocity - velocity).norm(), 1e-15);
  EXPECT_LT((p.position - time * velocity).norm(), 1e-14);
  EXPECT_LT((p.spin - spin).norm(), 1e-10 * spin.norm());
  const Quat expected = Quat(Eigen::AngleAxisd(turn, spin.normalized())) * driven.attitude;
  EXPECT_LT(expected.angularDistance(p.attitude), 1e-10);
}

// With a damper of the ratio x of the critical one, a collision with attraction leaves exp(-pi x /
// sqrt(1 - x^2)) of the speed, with the whole mass of the other particle if one of the two is held.
TEST(Held, IsInfinitelyHeavyInACollision) {
  const double zeta = 0.2;
  std::vector<dem::NewParticle> all{sphere_at(0, Vec3::Zero(), Vec3::Zero()),
                                    sphere_at(1, {0, 0.0205, 0}, {0, -0.5, 0})};
  all[0].held = true;
  dem::Parameters weightless;
  weightless.gravity = 0;
  dem::Particles particles(par::Comm::self(), test::one_material(damped()), weightless,
                           test::box({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}));
  particles.add_template(test::clump());
  particles.add_template(test::sphere());
  particles.add(all);
  const double mass = 2500 * 4.0 / 3.0 * std::numbers::pi * r * r * r;
  particles.advance(0.01, static_cast<int>(0.01 / (0.002 * std::sqrt(mass / 1e5))));
  const double left = std::exp(-std::numbers::pi * zeta / std::sqrt(1 - zeta * zeta));
  // Dampers are half a sub-step late: first order, 0.002 of a period here.
  EXPECT_NEAR(views_of(particles).at(1).velocity.y(), 0.5 * left, 2e-3 * 0.5);
  EXPECT_EQ(views_of(particles).at(0).velocity, Vec3::Zero());
}

// Two bodies approach at a constant speed and rub without slip, since one is driven. Friction is
// k_s times the path of the surfaces on each other, whose arms shorten meanwhile.
struct Rub {
  static constexpr double spin = 30, closing = 0.2, first_overlap = 1e-5, step = 5e-6;
  static constexpr double relative = 1e-11;  // rounding of positions, 1e-18 m, in each of 400 steps

  static dem::ContactLaw law() {
    dem::ContactLaw sticking;
    sticking.k_n = 1e6, sticking.k_s = 1e5, sticking.friction = 1e6;
    return sticking;
  }
  // m, up to the time t, of `arms` arms r that are shorter by the overlap in all.
  static double path(double t, double arms) {
    return spin * (arms * r * t - first_overlap * t - closing * t * t / 2);
  }
  // N, in 400 steps.
  static double friction(double arms) {
    return law().k_s * (path(500 * step, arms) - path(100 * step, arms));
  }
  // What the force on the first particle gains in the same steps, N.
  static Vec3 gain(dem::Particles& particles) {
    const auto force_after = [&](int steps) {
      particles.advance(steps * step, steps);
      EXPECT_EQ(particles.trouble(), "");
      return views_of(particles).at(0).force;
    };
    const Vec3 early = force_after(100);
    return force_after(400) - early;
  }
};

// Both balls rotate the same way; one is driven, the other so heavy that forces do not change its
// motion (two driven ones exert no forces on each other). The arms are r - delta / 2: with those of
// half a step before, the sum over the steps is the path to rounding; with those of the step itself
// the error would be u dt / (4 r) = 2.5e-5 here.
TEST(Held, BallsThatApproachRubByTheExactPath) {
  const double x = r - 0.5 * Rub::first_overlap;
  std::vector<dem::NewParticle> all{sphere_at(0, {-x, 0, 0}, {0.5 * Rub::closing, 0, 0}),
                                    sphere_at(1, {x, 0, 0}, {-0.5 * Rub::closing, 0, 0})};
  for (dem::NewParticle& p : all) p.spin = {0, 0, Rub::spin};
  all[0].held = true;
  dem::Parameters weightless;
  weightless.gravity = 0;
  dem::Particles particles(par::Comm::self(), test::one_material(Rub::law(), 1e18), weightless,
                           test::box({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}));
  particles.add_template(test::clump());
  particles.add_template(test::sphere());
  particles.add(all);
  const double expected = Rub::friction(2);
  EXPECT_NEAR(Rub::gain(particles).y(), -expected, Rub::relative * expected);
}

// A driven ball that is moved into a floor at rest: the arm is r - delta.
TEST(Held, ABallThatApproachesAFloorRubsByTheExactPath) {
  std::vector<dem::NewParticle> all{
      sphere_at(0, {0.001, 0.002, r - Rub::first_overlap}, {0, 0, -Rub::closing})};
  all[0].held = true, all[0].spin = {0, Rub::spin, 0};
  dem::Particles particles = scene_of(par::Comm::self(), all, Rub::law());
  Surface floor = test::floor_of(1, 0.1);
  particles.set_surfaces({&floor});
  const double expected = Rub::friction(1);
  EXPECT_NEAR(Rub::gain(particles).x(), expected, Rub::relative * expected);
}

TEST(Held, StaysDrivenWhenOthersAreStopped) {
  std::vector<dem::NewParticle> all{sphere_at(0, {0, 0, 0}, {1, 0, 0}),
                                    sphere_at(1, {0, 0.1, 0}, {1, 0, 0})};
  all[0].held = true;
  dem::Particles particles = scene_of(par::Comm::self(), all, damped());
  particles.stop();
  EXPECT_EQ(views_of(particles).at(0).velocity, Vec3::UnitX());
  EXPECT_EQ(views_of(particles).at(1).velocity, Vec3::Zero());
}

}  // namespace
}  // namespace trackbed::held_test
