// Bricks on a slope: below its angle Coulomb's friction holds them without creep, above it they
// slide with the remaining acceleration, alone and one upon the other.
#include <gtest/gtest.h>

#include "support/stones.hpp"

namespace trackbed::stones_slope_test {
namespace {

constexpr double mu = 0.7;           // its angle is 34.99 degrees
constexpr double rounding = 0.002;   // m
constexpr double density = 2650;     // kg/m^3
const Vec3 half(0.03, 0.03, 0.012);  // m; low enough not to tip over on these slopes

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 1e6, law.k_s = 0.8e6, law.friction = mu;
  law.zeta_n = law.zeta_s = 0.3;
  return law;
}

// A pile of bricks on a plane that descends towards +x.
struct Slope {
  dem::Particles particles;
  Surface plane;
  Quat tilt;
  double dt;  // s, a tenth of sqrt(m/k)

  Slope(double degrees, int count)
      : particles(par::Comm::self(), test::one_material(rough(), density), {.largest_overlap = 3},
                  test::box(Vec3::Constant(-9), Vec3::Constant(9))),
        plane(test::floor_of(7, 6)),
        tilt(Eigen::AngleAxisd(degrees * M_PI / 180, Vec3::UnitY())),
        dt(0.1 * std::sqrt(density * 8 * half.prod() / rough().k_n)) {
    for (Vec3& x : plane.position) x = tilt * x;
    std::vector<dem::NewParticle> bricks(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
      dem::NewParticle& one = bricks[static_cast<std::size_t>(k)];
      one.id = k;
      one.position = tilt * Vec3(0.013, 0.021, (2 * k + 1) * half.z());
      one.attitude = tilt;
    }
    particles.add_template(test::brick(half, rounding));
    particles.add(bricks);
    particles.set_surfaces({&plane});
  }
  Slope(const Slope&) = delete;
  void run(double seconds) {
    const int steps = static_cast<int>(seconds / dt);
    for (int done = 0; done < steps; done += 100) particles.advance(100 * dt, 100);
    ASSERT_EQ(particles.trouble(), "");
  }
  // m, down the slope.
  double along(std::size_t k) const { return (tilt.conjugate() * particles[k].position).x(); }
  double speed(std::size_t k) const { return (tilt.conjugate() * particles[k].velocity).x(); }
};

TEST(StonesOnSlope, BelowTheAngleOfFrictionTheyStayWhereTheyAre) {
  for (const int count : {1, 2}) {
    Slope slope(34, count);
    slope.run(0.5);
    std::vector<double> rest;
    for (int k = 0; k < count; ++k) rest.push_back(slope.along(static_cast<std::size_t>(k)));
    slope.run(1);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      EXPECT_NEAR(rest[k], 0.013, 1e-4) << k;           // m: the stretch of the springs
      EXPECT_NEAR(slope.along(k), rest[k], 1e-9) << k;  // no creep
      EXPECT_LT(slope.particles[k].velocity.norm(), 1e-9) << k;
    }
  }
}

TEST(StonesOnSlope, BeyondItTheySlideWithTheRemainingAcceleration) {
  for (const int count : {1, 2}) {
    const double degrees = 37, angle = degrees * M_PI / 180;
    const double left = gravity * (std::sin(angle) - mu * std::cos(angle));
    Slope slope(degrees, count);
    slope.run(0.5);
    const double before = slope.speed(0);
    slope.run(0.5);
    EXPECT_NEAR(slope.speed(0) - before, 0.5 * left, 0.02 * 0.5 * left) << count;
  }
}

}  // namespace
}  // namespace trackbed::stones_slope_test
