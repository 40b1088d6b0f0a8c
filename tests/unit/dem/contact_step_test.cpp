// The step above which contact forces alternate and grow, against exact eigenvalues and against the
// motion itself.
#include <gtest/gtest.h>

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

dem::ContactLaw law(double ratio, double zeta = 0) {
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
