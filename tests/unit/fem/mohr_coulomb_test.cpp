// Return mapping to the Mohr-Coulomb surface: properties for many random stresses and solids.
#include "fem/material/mohr_coulomb.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace trackbed::fem::mohr_coulomb_test {
namespace {

// Relative to the largest value: eigenvectors and a system of three.
constexpr double rounding = 1e-10;

double passive(double angle) {
  const double sine = std::sin(angle * std::numbers::pi / 180);
  return (1 + sine) / (1 - sine);
}

struct Case {
  Elastic solid;
  Strength strength;
  Vec6 stress;
};

// Solids from liquid-like to rock, with and without friction, dilation and tension; stresses from
// well within the surface to far beyond it, sometimes with equal principal values.
class Cases {
 public:
  Case next() {
    Case one;
    one.solid = {number(1e6, 1e9), number(0, 0.49), 2000};
    Strength& s = one.strength;
    s.yield = Yield::mohr_coulomb;
    s.friction_angle = chance(0.2) ? 0 : number(1, 50);
    s.dilation_angle = chance(0.3)   ? 0
                       : chance(0.3) ? s.friction_angle
                                     : number(0, s.friction_angle);
    s.cohesion = s.friction_angle > 0 && chance(0.2) ? 0 : number(1e3, 1e5);
    const double apex = s.friction_angle > 0
                            ? s.cohesion / std::tan(s.friction_angle * std::numbers::pi / 180)
                            : 1e5;
    s.tensile_strength = chance(0.3) ? 0 : chance(0.2) ? apex : number(0, apex);
    const double size = 1e4 * std::pow(10, number(-2, 2)), pressure = size * number(-1, 3);
    for (int k = 0; k < 6; ++k) one.stress(k) = size * number(-1, 1);
    if (chance(0.2)) one.stress.tail<3>().setZero();
    if (chance(0.2)) one.stress(3) = one.stress(4) = 0;
    if (chance(0.1)) one.stress(0) = one.stress(1);
    one.stress.head<3>().array() -= pressure;
    return one;
  }
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  bool chance(double share) { return number(0, 1) < share; }
  std::mt19937_64 random_{7};
};

TEST(MohrCoulomb, ReturnsOnlyStressesBeyondTheSurface) {
  Cases cases;
  int within = 0, beyond = 0;
  for (int n = 0; n < 100000; ++n) {
    const Case one = cases.next();
    const MohrCoulomb surface(one.solid, one.strength);
    const double size = one.stress.cwiseAbs().maxCoeff() * passive(one.strength.friction_angle) +
                        one.strength.cohesion;
    Vec6 stress = one.stress, plastic = Vec6::Zero();
    const double before = surface.beyond(principal(one.stress).value);
    if (!surface.bring_back(stress, plastic)) {
      EXPECT_LE(before, rounding * size);
      EXPECT_EQ(stress, one.stress);
      ++within;
      continue;
    }
    ++beyond;
    EXPECT_GT(before, 0);
    const Principal after = principal(stress);
    ASSERT_LE(surface.beyond(after.value), rounding * size) << n;
    // The plastic strain explains the stress change, its work is positive, principal axes are kept.
    EXPECT_LT((one.stress - elasticity(one.solid) * plastic - stress).norm(), rounding * size) << n;
    EXPECT_GE(stress.dot(plastic), -rounding * size * plastic.norm()) << n;
    Vec6 again = stress, nothing;
    surface.bring_back(again, nothing);
    EXPECT_LT((again - stress).norm(), rounding * size);
  }
  EXPECT_GT(within, 10000);
  EXPECT_GT(beyond, 10000);
}

// With associated flow no admissible stress does more work on the plastic strain (Hill 1948): the
// returned stress is the closest in energy, so it is unique.
TEST(MohrCoulomb, AssociatedFlowDissipatesMost) {
  Cases cases;
  int count = 0;
  for (int n = 0; n < 20000; ++n) {
    Case one = cases.next();
    one.strength.dilation_angle = one.strength.friction_angle;
    const MohrCoulomb surface(one.solid, one.strength);
    Vec6 stress = one.stress, plastic;
    if (!surface.bring_back(stress, plastic)) continue;
    Vec6 other = cases.next().stress, none;
    // Rounding is relative to the trial stresses, which may return to zero.
    const double size = one.stress.norm() + other.norm() + one.strength.cohesion;
    surface.bring_back(other, none);
    EXPECT_LE(plastic.dot(other - stress), 1e-9 * size * plastic.norm()) << n;
    ++count;
  }
  EXPECT_GT(count, 5000);
}

// The cones that avoid the principal values are within the surface, and not empty.
TEST(MohrCoulomb, ConesLieWithin) {
  Cases cases;
  int held = 0;
  for (int n = 0; n < 50000; ++n) {
    const Case one = cases.next();
    const MohrCoulomb surface(one.solid, one.strength);
    const double mean = one.stress.head<3>().sum() / 3;
    const Vec3 deviator = one.stress.head<3>().array() - mean;
    const double second = 0.5 * deviator.squaredNorm() + one.stress.tail<3>().squaredNorm();
    bool in = true;
    for (const auto& cone : surface.cones()) {
      const double left = cone.limit - cone.slope * mean;
      in = in && left >= 0 && cone.factor * second <= left * left;
    }
    if (!in) continue;
    ++held;
    EXPECT_LE(surface.beyond(principal(one.stress).value), rounding * one.stress.norm());
  }
  EXPECT_GT(held, 5000);
}

// Hand calculation of each region: c 10 kPa, phi 30 (N 3), psi 0, tension 5 kPa, G = lambda
// (nu 1/4).
TEST(MohrCoulomb, RegionsByHand) {
  Strength strength{Yield::mohr_coulomb, 10e3, 30, 0, 5e3};
  const MohrCoulomb surface({25e6, 0.25, 2000}, strength);
  const double limit = 2 * 10e3 * std::sqrt(3.0);
  const auto back = [&](double x, double y, double z) {
    Vec6 stress, plastic;
    stress << x, y, z, 0, 0, 0;
    EXPECT_TRUE(surface.bring_back(stress, plastic));
    return Vec3(stress.head<3>());
  };
  // Main plane: flow direction (1, 0, -1), so mean and middle stress are unchanged.
  const Vec3 main = back(-100e3, -250e3, -500e3);
  EXPECT_NEAR(3 * main.x() - main.z(), limit, 1e-6);
  EXPECT_NEAR(main.x() + main.z(), -600e3, 1e-6);
  EXPECT_NEAR(main.y(), -250e3, 1e-6);
  // Edge of triaxial compression: both smaller ones remain equal.
  const Vec3 edge = back(-500e3, -100e3, -100e3);
  EXPECT_NEAR(edge.y(), edge.z(), 1e-6);
  EXPECT_NEAR(3 * edge.y() - edge.x(), limit, 1e-6);
  EXPECT_NEAR(edge.sum(), -700e3, 1e-6);
  // All beyond the tension cut-off: its corner.
  EXPECT_LT((back(50e3, 60e3, 70e3) - Vec3::Constant(5e3)).norm(), 1e-6);
  // One tension: returned along its direction, the others follow by Poisson's ratio.
  const Vec3 cut = back(25e3, -10e3, -10e3);
  EXPECT_NEAR(cut.x(), 5e3, 1e-6);
  EXPECT_NEAR(cut.y(), -10e3 - 20e3 / 3, 1e-6);
}

// A strain path that reverses, in few or many returns: they converge with order one at least.
TEST(MohrCoulomb, SubStepsConverge) {
  const Elastic solid{50e6, 0.3, 2000};
  const MohrCoulomb surface(solid, {Yield::mohr_coulomb, 10e3, 35, 5, 2e3});
  const auto end = [&](int steps) {
    Vec6 stress, plastic, before = Vec6::Zero();
    stress << -50e3, -50e3, -50e3, 0, 0, 0;
    for (int n = 1; n <= steps; ++n) {
      const double t = std::numbers::pi * n / steps;
      Vec6 strain;
      strain << std::sin(t), 0.5 * (1 - std::cos(t)), -1.5 * std::sin(t), 0.7 * std::sin(2 * t),
          0.3 * t, std::sin(t);
      strain *= 3e-3;
      stress += elasticity(solid) * (strain - before);
      before = strain;
      surface.bring_back(stress, plastic);
    }
    return stress;
  };
  const Vec6 exact = end(20000);
  const double coarse = (end(20) - exact).norm(), fine = (end(80) - exact).norm();
  EXPECT_GT(coarse / fine, std::pow(4, 0.8));
  EXPECT_LT(coarse / fine, std::pow(4, 2.2));  // two where the path stays on one plane
  EXPECT_LT(fine, 0.02 * exact.norm());
}

}  // namespace
}  // namespace trackbed::fem::mohr_coulomb_test
