// Softer contacts of preparing stages: forces and steps follow the fraction of stiffness.
#include <gtest/gtest.h>

#include "support/scene.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::soft_contacts_test {
namespace {

dem::Physics physics(dem::LawKind kind) {
  dem::ContactLaw law;
  law.kind = kind;
  law.k_n = 2e6, law.k_s = 1.5e6, law.zeta_n = 0.3;  // linear
  law.restitution = 0.4;                             // hertz
  dem::Physics physics = test::one_material(law);
  physics.materials[0].young = 1e8;  // Pa
  return physics;
}

constexpr double radius = 0.02;  // m

// A ball at rest on a floor.
struct Scene {
  explicit Scene(dem::LawKind kind)
      : particles(par::Comm::self(), physics(kind), {},
                  test::box(Vec3::Constant(-1), Vec3::Constant(1))),
        floor(test::floor_of(1, 0.9)) {
    particles.add_template(test::sphere());
    dem::NewParticle one;
    one.scale = radius, one.position = Vec3(0.1, 0.2, radius);
    particles.add(std::span(&one, 1));
    particles.set_surfaces({&floor});
  }
  void rest(double seconds) {
    const double dt = particles.stable_step();
    const int steps = static_cast<int>(seconds / dt);
    particles.advance(steps * dt, steps);
  }
  double overlap() const { return radius - particles[0].position.z(); }

  dem::Particles particles;
  Surface floor;
};

// delta = m g / k, or (m g / k)^(2/3) with k proportional to the modulus.
TEST(SoftContacts, CarryTheSameWeightWithMoreOverlap) {
  constexpr double settled = 1e-4;  // relative, after 1 s
  for (const auto& [kind, power] :
       {std::pair(dem::LawKind::linear, 1.0), {dem::LawKind::hertz, 2.0 / 3}}) {
    Scene scene(kind);
    scene.rest(1);
    const double stiff = scene.overlap();
    scene.particles.set_stiffness(0.01);
    scene.rest(1);
    EXPECT_NEAR(scene.overlap() / stiff, std::pow(100, power), settled * 100);
    scene.particles.set_stiffness(0.25);  // of the law, not of the present one
    scene.rest(1);
    EXPECT_NEAR(scene.overlap() / stiff, std::pow(4, power), settled * 4);
    scene.particles.set_stiffness(1);
    scene.rest(1);
    EXPECT_NEAR(scene.overlap() / stiff, 1, settled);
    EXPECT_EQ(scene.particles.trouble(), "");
  }
}

// sqrt(m/k): ten times as long with a hundredth of the stiffness.
TEST(SoftContacts, AllowLongerSteps) {
  for (const dem::LawKind kind : {dem::LawKind::linear, dem::LawKind::hertz}) {
    Scene scene(kind);
    const double step = scene.particles.stable_step();
    scene.particles.set_stiffness(0.01);
    EXPECT_NEAR(scene.particles.stable_step(), 10 * step, 1e-12 * step);
    scene.particles.set_stiffness(1);
    EXPECT_EQ(scene.particles.stable_step(), step);
  }
}

// A disk between planes, where Hertz's law depends on the thickness, and a ball whose step the
// spring of rolling resistance limits.
TEST(SoftContacts, SoftenPlaneAndRollingContacts) {
  const auto ratio = [](const dem::Physics& whole, const dem::Domain& domain) {
    dem::Particles particles(par::Comm::self(), whole, {}, domain);
    particles.add_template(domain.dimension == Dimension::plane ? test::disk() : test::sphere());
    dem::NewParticle one;
    one.scale = radius;
    particles.add(std::span(&one, 1));
    const double step = particles.stable_step();
    particles.set_stiffness(0.01);
    return particles.stable_step() / step;
  };
  constexpr double rounding = 1e-12;
  dem::Domain plane = test::box(Vec3::Constant(-1), Vec3::Constant(1));
  plane.dimension = Dimension::plane;
  EXPECT_NEAR(ratio(physics(dem::LawKind::hertz), plane), 10, 10 * rounding);
  dem::Physics rolling = physics(dem::LawKind::linear);
  rolling.laws[0].rolling_friction = 0.1, rolling.laws[0].rolling_stiffness = 3;
  EXPECT_NEAR(ratio(rolling, test::box(Vec3::Constant(-1), Vec3::Constant(1))), 10, 10 * rounding);
}

TEST(SoftContacts, AreNamedWhereTheyOverlapTooFar) {
  Scene scene(dem::LawKind::linear);
  scene.particles.set_stiffness(1e-5);
  scene.rest(1);
  EXPECT_NE(scene.particles.trouble().find("contacts have 1e-05 times the stiffness"),
            std::string::npos);
}

TEST(SoftContacts, KeepTheFrictionThatWasSet) {
  Scene scene(dem::LawKind::linear), other(dem::LawKind::linear);
  for (dem::Particles* p : {&scene.particles, &other.particles}) p->set_friction(0.1);
  scene.particles.set_stiffness(0.5);
  scene.particles.set_stiffness(1);
  const auto slide = [](Scene& s) {
    for (Vec3& motion : s.floor.motion) motion.x() = 1e-4;
    s.rest(0.01);
    return s.particles.state_hash();
  };
  const std::uint64_t hash = slide(other);
  EXPECT_EQ(slide(scene), hash);
  Scene rough(dem::LawKind::linear);
  EXPECT_NE(slide(rough), hash);
}

}  // namespace
}  // namespace trackbed::soft_contacts_test
