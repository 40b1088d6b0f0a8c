// Friction between stones: its history through a change of features, torsion of faces, equilibrium.
#include <gtest/gtest.h>

#include "support/stone_pairs.hpp"

namespace trackbed::stones_history_test {
namespace {

constexpr double k = 1e6;      // N/m
constexpr double size = 0.04;  // m
constexpr double r = test::rounding * size;
constexpr double heavy = 1e15;  // times the mass of a stone: fixed

dem::Template fixed(dem::Template t) {
  t.volume *= heavy;
  return t;
}

// Stones of one material; a soft ball that loads them, so that its force hardly changes.
struct SoftLoad {
  double stiffness = 100;  // N/m
  double depth = 0.01;     // m
};

dem::Physics rough(double friction, double zeta, const SoftLoad& load = {}) {
  dem::ContactLaw law;
  law.k_n = k, law.k_s = 0.8 * k;
  law.friction = friction, law.zeta_n = law.zeta_s = zeta;
  dem::Physics physics = test::one_material(law);
  physics.materials.push_back({.name = "soft"});
  for (const char* other : {"stone", "soft"}) {
    dem::ContactLaw soft{.first = "soft", .second = other};
    soft.k_n = load.stiffness, soft.k_s = 0, soft.friction = 0;
    physics.laws.push_back(soft);
  }
  return physics;
}

// A box on a fixed box, loaded at its centre by a fixed ball: a load of k depth.
struct Pile {
  dem::Particles p;
  double mass;  // kg, of the upper box

  Pile(const dem::Template& lower, const dem::Template& upper, const dem::NewParticle& on_top,
       double zeta, double friction = 0.5)
      : p(par::Comm::self(), rough(friction, zeta), loose(),
          test::box(Vec3::Constant(-1), Vec3::Ones())) {
    const double ball = 0.03;  // m; more than the depth of the loading ball
    p.add_template(fixed(lower)), p.add_template(upper), p.add_template(fixed(test::sphere(ball)));
    std::vector<dem::NewParticle> all(3);
    for (int n = 0; n < 3; ++n)
      all[static_cast<std::size_t>(n)].id = n, all[static_cast<std::size_t>(n)].shape = n;
    all[0].scale = size;
    all[1] = on_top;
    all[1].id = all[1].shape = 1;
    all[2].material = 1;
    all[2].position = Vec3(0, 0, on_top.position.z() + 0.3 * size + ball - SoftLoad{}.depth);
    p.add(all);
    mass = p[1].mass;
  }
  static dem::Parameters loose() {
    dem::Parameters parameters;
    parameters.gravity = 0, parameters.largest_overlap = 1e3;
    return parameters;
  }
  double dt(double share) const { return share * std::sqrt(mass / k); }
  double kinetic(const dem::Template& shape) const {
    const dem::ParticleView v = p[1];
    const Vec3 spin = v.attitude.conjugate() * v.spin;
    return 0.5 * v.mass *
           (v.velocity.squaredNorm() + size * size * spin.cwiseAbs2().dot(shape.gyration));
  }
};

const dem::Template& block() {
  static const dem::Template shape = test::cuboid({0.5, 0.4, 0.3});
  return shape;
}

dem::NewParticle lying(double gap, const Quat& attitude = Quat::Identity()) {
  dem::NewParticle n;
  n.scale = size;
  n.attitude = attitude;
  n.position = Vec3(0, 0, 0.6 * size + gap);
  return n;
}

TEST(StoneRest, ABoxOnABoxComesToRest) {
  // Dropped with a rotation about the vertical, so that no feature coincides with another.
  const Quat turn(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  Pile pile(block(), block(), lying(1e-4, turn), 0.3);
  const double weight = SoftLoad{}.stiffness * SoftLoad{}.depth;  // N
  const double dropped = weight * 1e-4;                           // J
  double most = 0;
  for (int s = 0; s < 400; ++s) {
    pile.p.advance(50 * pile.dt(0.1), 50);
    most = std::max(most, pile.kinetic(block()));
  }
  EXPECT_GT(most, 0.05 * dropped);  // it has moved
  EXPECT_LT(pile.kinetic(block()), 1e-12 * dropped);
  const double up = (pile.p[1].attitude * Vec3::UnitZ()).z();
  EXPECT_NEAR(up, 1, 1e-9);  // flat
  EXPECT_NEAR(pile.p[1].force.z(), 0, 1e-6 * weight);
}

TEST(StoneRest, ATiltedBoxTiltsBack) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, 0.8, 0)}) {
    const Quat tilt(Eigen::AngleAxisd(0.06, axis));
    const double lift = size * 0.06 * (0.5 * std::abs(axis.y()) + 0.4 * std::abs(axis.x()));
    Pile pile(block(), block(), lying(lift, tilt), 0.3);
    for (int s = 0; s < 400; ++s) pile.p.advance(100 * pile.dt(0.1), 100);
    EXPECT_GT((pile.p[1].attitude * Vec3::UnitZ()).z(), 1 - 1e-9);
    EXPECT_LT(pile.kinetic(block()), 1e-12 * SoftLoad{}.stiffness * SoftLoad{}.depth * lift);
  }
}

TEST(StoneFriction, FacesStopRelativeSpin) {
  dem::NewParticle n = lying(-1e-6);
  n.spin = Vec3(0, 0, 5);
  Pile pile(block(), block(), n, 0.3);
  const double dt = pile.dt(0.1);
  double largest = 0;
  for (int s = 0; s < 600; ++s) {
    pile.p.advance(100 * dt, 100);
    largest = std::max(largest, pile.p[1].spin.z());
  }
  EXPECT_LE(largest, 5);
  EXPECT_NEAR(pile.p[1].spin.z(), 0, 1e-6);
  // Without friction it continues.
  Pile smooth(block(), block(), n, 0.3, 0);
  for (int s = 0; s < 600; ++s) smooth.p.advance(100 * dt, 100);
  EXPECT_GT(smooth.p[1].spin.z(), 4.9);
}

// Largest jump of the force on a stone that slides over another in contact, over the largest force;
// rotation of the normal.
struct Slide {
  double jump = 0, force = 0, friction = 0, turned = 0;
};

Slide slide(double share, std::uint64_t seed) {
  const dem::Template upper = test::stone(seed), lower = test::stone(seed + 1);
  dem::NewParticle a, b;
  a.scale = b.scale = size;
  b.position = Vec3(0, 0, 2 * size);
  test::bring_near(lower, a, upper, b, 1e-7);
  b.velocity = Vec3(0.4, 0.1, -0.02);
  b.spin = Vec3(0, 20, 0);
  Pile pile(lower, upper, b, 0, 0.6);
  const double dt = pile.dt(share);
  const int count = static_cast<int>(0.02 / dt);
  Slide result;
  Vec3 last = Vec3::Zero(), first = Vec3::Zero();
  for (int s = 0; s < count; ++s) {
    pile.p.advance(dt, 1);
    Vec3 force = Vec3::Zero();
    pile.p.contacts([&](const dem::ContactView& c) {
      if (c.first == 0 && c.second == 1) force = -c.force;
    });
    if (force.norm() > 0 && first.isZero()) first = force;
    result.jump = std::max(result.jump, (force - last).norm());
    result.force = std::max(result.force, force.norm());
    if (force.norm() > 0)
      result.turned =
          std::max(result.turned, std::acos(force.dot(first) / force.norm() / first.norm()));
    last = force;
  }
  return result;
}

TEST(StoneFriction, HistorySurvivesAChangeOfFeatures) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Slide coarse = slide(0.04, seed), fine = slide(0.01, seed);
    EXPECT_GT(coarse.turned, 0.25);            // rad
    EXPECT_LT(fine.jump, 0.35 * coarse.jump);  // a real jump would not fall with the step
  }
}

}  // namespace
}  // namespace trackbed::stones_history_test
