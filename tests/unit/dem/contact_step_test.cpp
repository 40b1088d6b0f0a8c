// The step above which contact forces alternate and grow, against exact eigenvalues and against the
// motion itself.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "support/scene.hpp"

namespace trackbed::contact_step_test {
namespace {

constexpr double r = 0.02, density = 2500, k_n = 1e6;          // m, kg/m^3, N/m
constexpr double overlap = 1e-3 * r, lever = r - overlap / 2;  // m
constexpr int count = 12;
const double mass = density * 4.0 / 3 * M_PI * r * r * r;

// Equal balls in a periodic row, each in contact with two others.
struct Ring {
  dem::Particles particles;

  Ring(const par::Comm& comm, const dem::ContactLaw& law, const Vec3& spin = Vec3::Zero())
      : particles(comm, test::one_material(law, density), {}, domain()) {
    particles.add_template(test::sphere());
    std::vector<dem::NewParticle> all(count);
    for (int i = 0; i < count; ++i) {
      dem::NewParticle& ball = all[static_cast<std::size_t>(i)];
      ball.id = 5 * i + 2, ball.scale = r;
      ball.position = {(i + 0.5) * 2 * lever, 0, 0};
      ball.spin = spin;
    }
    particles.add(test::mine(comm, all));
    particles.advance(1e-12, 1);  // finds the contacts
  }
  static dem::Domain domain() {
    dem::Domain domain = test::box({0, -5 * r, -5 * r}, {count * 2 * lever, 5 * r, 5 * r});
    domain.periodic = {true, false, false};
    return domain;
  }
};

dem::ContactLaw law(double ratio, double zeta = 0) {  // friction is never reached
  dem::ContactLaw law;
  law.k_n = k_n, law.k_s = ratio * k_n, law.friction = 10;
  law.zeta_n = law.zeta_s = zeta;
  return law;
}

// Neighbours that move against each other (4 k_n / m), and balls that all turn in the same sense,
// which slide on both neighbours: 4 k_s lever^2 / I.
double largest(double normal, double shear) {
  return std::max(4 * normal, 10 * shear * std::pow(lever / r, 2)) / mass;
}

// The iteration spans all motions of twelve balls, so that rounding alone remains.
constexpr double rounding = 1e-8;

TEST(ContactStep, IsThatOfTheLargestEigenvalue) {
  const par::Comm comm = par::Comm::world();
  const double dt = 0.3 * std::sqrt(mass / k_n);
  for (const double ratio : {0.1, 1.0})
    for (const double zeta : {0.0, 0.2}) {
      const Ring ring(comm, law(ratio, zeta));
      const auto with_dashpot = [&](double k) {
        return dt * dt * k + 2 * dt * 2 * zeta * std::sqrt(k * mass / 2);
      };
      const double wanted = largest(with_dashpot(k_n), with_dashpot(ratio * k_n)) / 4;
      EXPECT_NEAR(ring.particles.alternation(dt), wanted, rounding * wanted) << ratio << zeta;
    }
}

TEST(ContactStep, IsThatOfABallOnAFloor) {
  const par::Comm comm = par::Comm::world();
  dem::Particles particles(comm, test::one_material(law(1), density), {},
                           test::box({-1, -1, -1}, {1, 1, 1}));
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> ball(1);
  ball[0].scale = r, ball[0].position = {0, 0, r - overlap};
  particles.add(test::mine(comm, ball));
  Surface floor = test::floor_of(1, 0.5);
  particles.set_surfaces({&floor});
  EXPECT_EQ(particles.alternation(1e-4), 0) << "no contact is known yet";
  particles.advance(1e-12, 1);
  const double dt = 1e-4, arm = r - overlap;
  const double wanted = dt * dt * k_n * (1 + 2.5 * std::pow(arm / r, 2)) / mass / 4;
  EXPECT_NEAR(particles.alternation(dt), wanted, rounding * wanted);
}

// No tangential force acts without friction, so none alternates.
TEST(ContactStep, WithoutFrictionIsThatOfTheNormalForces) {
  const par::Comm comm = par::Comm::world();
  dem::ContactLaw smooth = law(1);
  smooth.friction = 0;
  const Ring ring(comm, smooth);
  const double dt = 0.3 * std::sqrt(mass / k_n), wanted = dt * dt * k_n / mass;
  EXPECT_NEAR(ring.particles.alternation(dt), wanted, rounding * wanted);
}

// The stiffness of a Hertz contact is 3/2 of force over overlap.
TEST(ContactStep, OfHertzContactsIsThatOfTheirTangent) {
  const par::Comm comm = par::Comm::world();
  dem::ContactLaw hertz;
  hertz.kind = dem::LawKind::hertz, hertz.friction = 0;
  dem::Physics physics = test::one_material(hertz, density);
  physics.materials[0].young = 1e9, physics.materials[0].poisson = 0.25;
  dem::Particles particles(comm, physics, {}, test::box({-1, -1, -1}, {1, 1, 1}));
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> pair(2);
  for (std::size_t k = 0; k < 2; ++k)
    pair[k].id = static_cast<Id>(k), pair[k].scale = r,
    pair[k].position = {(k == 0 ? -lever : lever), 0, 0};
  particles.add(test::mine(comm, pair));
  particles.advance(1e-12, 1);
  const double effective = 1e9 / (2 * (1 - 0.25 * 0.25)), dt = 1e-5;
  const double tangent = 2 * effective * std::sqrt(r / 2 * overlap);
  const double wanted = dt * dt * 2 * tangent / mass / 4;
  EXPECT_NEAR(particles.alternation(dt), wanted, 1e-6 * wanted);
}

// Two clumps that touch once: the eigenvalues are those of the spring in the mobility of the point
// of contact, a matrix of three rows.
TEST(ContactStep, OfTwoClumpsIsThatOfTheirMobility) {
  const par::Comm comm = par::Comm::world();
  dem::Particles particles(comm, test::one_material(law(0.7), density), {},
                           test::box({-1, -1, -1}, {1, 1, 1}));
  particles.add_template(test::clump());
  std::vector<dem::NewParticle> pair(2);
  // The first pieces, away from the others, face each other along an oblique line.
  const Vec3 outwards = Vec3(-1, -0.3, 0).normalized();
  pair[0].attitude = Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized());
  const Vec3 line = pair[0].attitude * outwards;
  pair[1].attitude = Quat::FromTwoVectors(outwards, -line) * Quat(Eigen::AngleAxisd(0.7, outwards));
  for (std::size_t k = 0; k < 2; ++k) pair[k].id = static_cast<Id>(k), pair[k].scale = r;
  pair[1].scale = 1.4 * r;
  const Vec3 first(-0.5, -0.08, 0.02);
  pair[0].position = -r * (pair[0].attitude * first);
  pair[1].position = (0.5 * 2.4 * r - overlap) * line - 1.4 * r * (pair[1].attitude * first);
  particles.add(test::mine(comm, pair));
  particles.advance(1e-12, 1);
  std::int64_t contacts = 0;
  Mat3 mobility = Mat3::Zero(), spring = Mat3::Zero();
  particles.contacts([&](const dem::ContactView& c) {
    ++contacts;
    spring = 0.7 * k_n * Mat3::Identity() + 0.3 * k_n * c.normal * c.normal.transpose();
    for (const auto& [k, centre] : {std::pair{0, c.first_centre}, std::pair{1, c.second_centre}}) {
      const double size = pair[static_cast<std::size_t>(k)].scale;
      const double m = density * 0.9 * size * size * size;
      const Mat3 axes = pair[static_cast<std::size_t>(k)].attitude.toRotationMatrix();
      const Vec3 moments = m * size * size * Vec3(0.08, 0.15, 0.19);
      Mat3 arm;  // rows: cross product with the lever
      const Vec3 l = c.point - centre;
      arm << 0, -l.z(), l.y(), l.z(), 0, -l.x(), -l.y(), l.x(), 0;
      mobility += Mat3::Identity() / m + arm.transpose() * axes *
                                             moments.cwiseInverse().asDiagonal() *
                                             axes.transpose() * arm;
    }
  });
  ASSERT_EQ(comm.sum(contacts), 1);
  const double dt = 1e-5;
  const Mat3 product = mobility * spring;
  const double wanted = comm.max(dt * dt * product.eigenvalues().real().maxCoeff() / 4);
  EXPECT_NEAR(particles.alternation(dt), wanted, rounding * wanted);
}

TEST(ContactStep, FindsTheLongestStep) {
  const par::Comm comm = par::Comm::world();
  for (const double zeta : {0.0, 0.2}) {
    const Ring ring(comm, law(1, zeta));
    const double stable = ring.particles.stable_step(1e-2);
    EXPECT_NEAR(ring.particles.alternation(stable), 1, 2e-3) << zeta;
    EXPECT_EQ(ring.particles.stable_step(0.5 * stable), 0.5 * stable);
  }
}

// The spin of the balls after some steps over that at the start.
double growth(const par::Comm& comm, double dt) {
  Ring ring(comm, law(1), {0, 0, 1e-6});
  ring.particles.advance(60 * dt, 60);
  double spin = 0;
  for (std::size_t i = 0; i < ring.particles.size(); ++i)
    spin = std::max(spin, std::abs(ring.particles[i].spin.z()));
  return comm.max(spin) / 1e-6;
}

// The growth in a step is 1.33 at 1.02 times the limit of the squared step.
TEST(ContactStep, SeparatesMotionsThatGrowFromOthers) {
  const par::Comm comm = par::Comm::world();
  const double limit = 2 / std::sqrt(largest(k_n, k_n));
  EXPECT_LT(growth(comm, std::sqrt(0.98) * limit), 20);
  EXPECT_GT(growth(comm, std::sqrt(1.02) * limit), 1e5);
}

}  // namespace
}  // namespace trackbed::contact_step_test
