// The law of one contact, called directly: what no trajectory shows cleanly.
#include <gtest/gtest.h>

#include "dem/laws.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::dem {
namespace {

constexpr Coefficients elastic{.k_n = 1e6, .k_s = 1e6, .c_n = 0, .c_s = 0, .mu = 0.5, .least = 0};

TEST(ContactLaw, HistoryTurnsWithThePair) {
  // A stretched contact whose two particles turn together about the normal: the spring turns along,
  // a quarter turn in 1000 steps, and keeps its length.
  Vec4 xi{1e-5, 0, 0, 0};
  const double dt = 1e-5, quarter = 0.5 * M_PI;
  const Touch touch{0, 0, 1, 0, 0, 0, 1e-4, quarter / (1000 * dt)};
  for (int k = 0; k < 1000; ++k) contact_force(elastic, touch, dt, xi);
  constexpr double first_order = 2e-3;  // each step lengthens it by (turn^2)/2: 1.2e-3 in all
  EXPECT_NEAR(xi.x, 0, first_order * 1e-5);
  EXPECT_NEAR(xi.y, 1e-5, first_order * 1e-5);
  EXPECT_EQ(xi.z, 0);
}

TEST(ContactLaw, HistoryIsBroughtIntoTheTangentPlane) {
  Vec4 xi{1e-5, 0, 1e-5, 0};
  contact_force(elastic, {0, 0, 1, 0, 0, 0, 1e-4, 0}, 1e-5, xi);
  EXPECT_EQ(xi.z, 0);
  EXPECT_EQ(xi.x, 1e-5);
}

// Softer springs along the contact allow more, dampers less; the least of all laws counts.
TEST(ContactLaw, SteadyStepsAreThoseOfTheWorstLaw) {
  const auto law = [](double k_s, double zeta) {
    ContactLaw c;
    c.k_n = 1e6, c.k_s = k_s, c.zeta_n = zeta;
    return c;
  };
  Physics physics;
  EXPECT_TRUE(std::isinf(steady_safety(physics)));
  physics.laws = {law(1e6, 0)};
  EXPECT_NEAR(steady_safety(physics), 2 / std::sqrt(30.0), 1e-12);
  physics.laws.push_back(law(3e5, 0));
  EXPECT_NEAR(steady_safety(physics), 2 / std::sqrt(30.0), 1e-12);
  physics.laws = {law(3e5, 0)};
  EXPECT_GT(steady_safety(physics), 1.2 * 2 / std::sqrt(30.0));
  physics.laws.push_back(law(3e5, 0.5));  // x = 1
  EXPECT_NEAR(steady_safety(physics), 2 / std::sqrt(20.2) * (std::sqrt(2.0) - 1), 1e-12);
}

TEST(ContactLaw, FrictionStopsAtCoulombsLimit) {
  const double normal = elastic.k_n * 1e-4;
  Vec4 xi{3e-5, 4e-5, 0, 0};  // its spring would carry half the normal force: just at the limit
  const Vec4 holds = contact_force(elastic, {0, 0, 1, 0, 0, 0, 1.0001e-4, 0}, 1e-5, xi);
  EXPECT_NEAR(std::hypot(holds.x, holds.y), 0.5 * normal, 1e-9 * normal);
  xi = {6e-5, 8e-5, 0, 0};
  const Vec4 slips = contact_force(elastic, {0, 0, 1, 0, 0, 0, 1e-4, 0}, 1e-5, xi);
  EXPECT_NEAR(std::hypot(slips.x, slips.y), 0.5 * normal, 1e-12 * normal);
  EXPECT_NEAR(xi.x, 3e-5, 1e-17);  // the history is what carries exactly this force
  EXPECT_NEAR(xi.y, 4e-5, 1e-17);
  EXPECT_LT(slips.x, 0);  // against the displacement
}

TEST(ContactLaw, DampingDoesNotPullUnlessAllowed) {
  Coefficients c = elastic;
  c.c_n = 1e3;
  Vec4 xi;
  const Touch opening{0, 0, 1, 0, 0, -1, 1e-4, 0};  // 100 N of spring, 1000 N of damping
  EXPECT_EQ(contact_force(c, opening, 1e-5, xi).z, 0);
  c.least = -std::numeric_limits<double>::infinity();
  EXPECT_NEAR(contact_force(c, opening, 1e-5, xi).z, 900, 1e-9);
}

}  // namespace
}  // namespace trackbed::dem
