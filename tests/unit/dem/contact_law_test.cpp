// The law of one contact, called directly, for properties that trajectories do not isolate.
#include <gtest/gtest.h>

#include <cmath>

#include "dem/contact/stone_law.hpp"
#include "dem/law/laws.hpp"
#include "support/scene.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::dem::contact_law_test {
namespace {

using Stretch = Triple<double>;

constexpr Coefficients<double> elastic{
    .k_n = 1e6, .k_s = 1e6, .c_n = 0, .c_s = 0, .mu = 0.5, .least = 0, .size = 1};

// Force on i at this overlap, normal along z, with a spring of constant stiffness.
Stretch force(const Coefficients<double>& c, const Stretch& v, double delta, double dt, Stretch& xi,
              double twist = 0) {
  const Touch<double> touch{{0, 0, 1}, v, delta, twist};
  const auto contact =
      contact_force(c, touch, NormalSpring<double>{c.k_n * delta, 0, 0}, 1.0, dt, xi);
  return contact.friction - contact.normal * touch.n;
}

// Two stones, one upon the other, rotate about their common normal at different rates.
TEST(ContactLaw, AStretchTurnsWithTheMeanSpinOfTwoStones) {
  const double dt = 1e-4, first = 1e-7;
  const auto stretch = [&](double spin_i, double spin_j) {
    StoneTouch<double> g{};
    g.d = {0, 0, 0.02}, g.N = {0, 0, 1}, g.x = {0, 0, 0.01}, g.M = 1e-6;
    g.wi = {0, 0, spin_i}, g.wj = {0, 0, spin_j};
    g.root_mass = 0.1, g.radius = 1e-3;
    g.law = {.k_n = 1e6, .k_s = 8e5, .mu = 1};
    StoneStretch<double> h{{first, 0, 0}, {}, 0, 1, 0};
    respond<false>(
        g, [](const Stretch&, bool) { return 0.0; }, dt, h);
    return h.xi;
  };
  constexpr double second_order = 1e-5;  // square of the turn of a step
  for (const auto& [i, j] : {std::pair(30.0, 10.0), {10.0, 30.0}, {-20.0, 20.0}}) {
    const double turn = 0.5 * (i + j) * dt;
    EXPECT_NEAR(stretch(i, j).y, turn * first, second_order * first) << i << " " << j;
  }
}

// A face that slides and rotates: force and moment over the arm share Coulomb's limit, in the
// directions of slip and of rotation times the arm.
TEST(ContactLaw, AFaceSharesItsFrictionBetweenSlipAndRotation) {
  constexpr double mu = 0.4, arm = 0.02, dt = 1e-5;
  for (const auto& [slip, spin] : {std::pair(1.0, 0.0), {1.0, 5.0}, {0.01, 30.0}, {0.0, 2.0}}) {
    StoneTouch<double> g{};
    g.N = {0, 0, 1}, g.M = 1e-5, g.spread = arm * arm;
    // Both rotate as fast, so that the stretch keeps its direction in space.
    g.vi = {0.6 * slip, 0.8 * slip, 0}, g.wi = {0, 0, 0.5 * spin}, g.wj = {0, 0, -0.5 * spin};
    g.root_mass = 0.1, g.radius = 1e-3;
    g.law = {.k_n = 1e6, .k_s = 8e5, .mu = mu};
    StoneStretch<double> h{{0, 1e-7, 0}, {}, 0, 1, arm * arm};
    StoneForce<double> f{};
    for (int step = 0; step < 3000; ++step)
      f = respond<false>(
          g, [](const Stretch&, bool) { return 0.0; }, dt, h);
    const double limit = mu * f.f_n, speed = std::hypot(slip, arm * spin);
    constexpr double rounding = 1e-9;
    EXPECT_NEAR(f.friction.x, -limit * 0.6 * slip / speed, rounding * limit) << slip << " " << spin;
    EXPECT_NEAR(f.friction.y, -limit * 0.8 * slip / speed, rounding * limit) << slip << " " << spin;
    EXPECT_NEAR(f.moment, -limit * arm * arm * spin / speed, rounding * limit * arm)
        << slip << " " << spin;
  }
}

// 4/3 E*, 8 G* and the dampers of both stiffnesses (Tsuji et al. 1992); parallel cylinders in a
// plane have k_s/k_n = 4 G*/E*.
TEST(ContactLaw, HertzHasTheDampersOfBothStiffnesses) {
  constexpr double young = 2e9, nu = 0.3, e = 0.5;
  ContactLaw law{.first = "a", .second = "a"};
  law.kind = LawKind::hertz, law.restitution = e;
  Physics physics;
  physics.materials = {{.name = "a", .young = young, .poisson = nu}};
  physics.laws = {law};
  const Springs<double> s = LawTable(physics)[0].springs;
  const double e_star = young / (2 * (1 - nu * nu)), g_star = young / (4 * (2 - nu) * (1 + nu));
  EXPECT_NEAR(s.k_n, 4.0 / 3 * e_star, 1e-9 * s.k_n);
  EXPECT_NEAR(s.k_s, 8 * g_star, 1e-9 * s.k_s);
  EXPECT_NEAR(s.c_s / s.c_n, std::sqrt(8 * g_star / (2 * e_star)), 1e-9);
  physics.thickness = 0.7;  // m
  const Springs<double> line = LawTable(physics)[0].springs;
  EXPECT_NEAR(line.k_n, M_PI / 4 * e_star * physics.thickness, 1e-9 * line.k_n);
  EXPECT_NEAR(line.k_s / line.k_n, 4 * g_star / e_star, 1e-9);
}

// Resistance to rolling is limited by the normal force, f_n |N|.
TEST(ContactLaw, RollingOfAFaceIsLimitedByItsNormalForce) {
  constexpr double mu = 0.1, radius = 0.03, dt = 1e-5, length = 1.26;
  StoneTouch<double> g{};
  g.N = {0, 0, length}, g.M = 1e-5, g.root_mass = 0.1, g.radius = 1e-3;
  g.law = {.k_n = 1e6}, g.rolling = {.mu = mu, .stiffness = 1}, g.rolling_radius = radius;
  g.wi = {3, -4, 0};
  StoneStretch<double> h{};
  StoneForce<double> f{};
  for (int step = 0; step < 1000; ++step)
    f = respond<true>(
        g, [](const Stretch&, bool) { return 0.0; }, dt, h);
  EXPECT_NEAR(f.force.z, -f.f_n * length, 1e-12 * f.f_n);
  const double limit = radius * mu * f.f_n * length;
  EXPECT_NEAR(f.turn_i.x, -0.6 * limit, 1e-9 * limit);
  EXPECT_NEAR(f.turn_i.y, 0.8 * limit, 1e-9 * limit);
  EXPECT_EQ(f.turn_j.x, f.turn_i.x);  // of the opposite sign when it is added
}

// Restitution of a head-on impact on a contact whose normal has the length |N|: n equal features
// have n^(1/6). The damping ratio is that of the law, whatever |N|.
TEST(ContactLaw, AFaceHasTheRestitutionOfACorner) {
  constexpr double mass = 0.5, speed = 0.3, zeta = 0.2, dt = 1e-6;
  const auto restitution = [&](double length, bool hertz) {
    StoneTouch<double> g{};
    g.N = {0, 0, length}, g.root_mass = std::sqrt(mass), g.radius = 5e-3;
    g.law = {.k_n = hertz ? 1e9 : 1e6, .hertz = hertz ? 1.0 : 0.0};
    g.law.c_n = 2 * zeta * std::sqrt(g.law.k_n);
    StoneStretch<double> h{};
    double v = speed, depth = 0;
    do {
      depth += dt * v, g.M = length * depth, g.vi = {0, 0, v};
      const auto f = respond<false>(
          g, [](const Stretch&, bool) { return 0.0; }, dt, h);
      v += dt * f.force.z / mass;
    } while (depth > 0);
    return -v / speed;
  };
  for (const bool hertz : {false, true}) {
    const double corner = restitution(1, hertz);
    EXPECT_GT(corner, 0.4);
    EXPECT_LT(corner, 0.7);
    // A contact takes some 1000 steps; of first order in the step.
    for (const double features : {2, 4})
      EXPECT_NEAR(restitution(std::pow(features, 1.0 / 6), hertz), corner, 2e-3);
  }
}

TEST(ContactLaw, HistoryTurnsWithThePair) {
  // A stretched contact whose two particles rotate together about the normal: the spring rotates
  // with them, a quarter turn in 1000 steps, and never becomes longer, which would be work from
  // nothing.
  Stretch xi{1e-5, 0, 0};
  const double dt = 1e-5, quarter = 0.5 * M_PI;
  double length = 1e-5;
  for (int k = 0; k < 1000; ++k) {
    force(elastic, {}, 1e-4, dt, xi, quarter / (1000 * dt));
    EXPECT_LE(std::hypot(xi.x, xi.y), length);
    length = std::hypot(xi.x, xi.y);
  }
  constexpr double second_order = 1e-6;  // angle^3 / 3 and length^4 of a step, times 1000 steps
  EXPECT_NEAR(xi.x, 0, second_order * 2e-5);
  EXPECT_NEAR(xi.y, 1e-5, second_order * 1e-5);
  EXPECT_EQ(xi.z, 0);
}

TEST(ContactLaw, HistoryIsBroughtIntoTheTangentPlane) {
  Stretch xi{1e-5, 0, 1e-5};
  force(elastic, {}, 1e-4, 1e-5, xi);
  EXPECT_EQ(xi.z, 0);
  EXPECT_EQ(xi.x, 1e-5);
}

// Softer tangential springs allow larger steps, dampers smaller ones; the least of all laws counts.
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
  Stretch xi{3e-5, 4e-5, 0};  // its spring carries half the normal force: just at the limit
  const Stretch holds = force(elastic, {}, 1.0001e-4, 1e-5, xi);
  EXPECT_NEAR(std::hypot(holds.x, holds.y), 0.5 * normal, 1e-9 * normal);
  xi = {6e-5, 8e-5, 0};
  const Stretch slips = force(elastic, {}, 1e-4, 1e-5, xi);
  EXPECT_NEAR(std::hypot(slips.x, slips.y), 0.5 * normal, 1e-12 * normal);
  EXPECT_NEAR(xi.x, 3e-5, 1e-17);  // the history is the stretch that carries exactly this force
  EXPECT_NEAR(xi.y, 4e-5, 1e-17);
  EXPECT_LT(slips.x, 0);  // against the displacement
}

// However strong the dashpot: while the contact slides the friction is at the limit, and the spring
// is stretched along the slip and no further than the limit.
TEST(ContactLaw, ADashpotNeverStretchesTheSpringAgainstTheSlip) {
  Coefficients<double> c = elastic;
  c.c_s = 1e4;
  Stretch xi{};
  for (int k = 0; k < 100; ++k) {
    const Stretch f = force(c, {1, 0, 0}, 1e-4, 1e-6, xi);
    EXPECT_NEAR(f.x, -50, 1e-9) << k;
    EXPECT_GT(xi.x, 0);
    EXPECT_LE(c.k_s * xi.x, 50 * (1 + 1e-12));
  }
}

// Hertz: F = k_s xi is constant while the contact grows and falls with the contact's size.
TEST(ContactLaw, TheForceOfAHertzSpringNeverGrowsByItself) {
  Coefficients<double> c = elastic;
  c.mu = 10;
  Stretch xi{1e-5, 0, 0};
  double before = c.size;
  const auto at = [&](double size) {
    c.size = size, c.k_n = c.k_s = 1e6 * size;
    const Touch<double> touch{{0, 0, 1}, {}, 1e-4, 0};
    const auto contact = contact_force(c, touch, NormalSpring<double>{c.k_n * 1e-4, 0, 0},
                                       softening(before, size), 1e-6, xi);
    before = size;
    return contact.friction.x;
  };
  EXPECT_NEAR(at(1), -10, 1e-12);
  EXPECT_NEAR(at(2), -10, 1e-12);
  EXPECT_NEAR(at(4), -10, 1e-12);
  EXPECT_NEAR(at(1), -2.5, 1e-12);
  EXPECT_NEAR(at(4), -2.5, 1e-12);
}

// Where a Hertz contact closes or opens its spring is in compression for any step, and its force is
// at most that at an overlap of two steps' travel.
TEST(ContactLaw, AHertzSpringIsInCompressionAtItsEnds) {
  Springs<double> spring{};
  spring.k_n = 1e9, spring.hertz = 1;
  constexpr double radius = 0.01, s = 1e-6, dt = 1e-6;
  for (const double mass : {1e-9, 1e-7, 1e-5, 1e-3, 1e3})
    for (const double rate : {s / dt, -s / dt})
      for (double delta = 1e-12; delta < s; delta += 0.01 * s) {
        const auto c = coefficients<true>(spring, delta, std::sqrt(mass), radius);
        const double force = spring_force<true>(spring, c, OverlapMotion<double>{delta, rate},
                                                end_mass(mass), radius, dt)
                                 .force;
        const double travel = s + (rate < 0 ? dt * dt * c.k_n * delta / mass : 0.0);
        const double deep = 2 * travel * std::sqrt(radius * 2 * travel) * spring.k_n;
        EXPECT_GT(force, 0) << mass << " " << rate << " " << delta;
        EXPECT_LT(force, deep) << mass << " " << rate << " " << delta;
      }
}

TEST(ContactLaw, DampingDoesNotPullUnlessAllowed) {
  Coefficients<double> c = elastic;
  c.c_n = 1e3;
  Stretch xi{};
  const Stretch opening{0, 0, -1};  // 100 N of spring, 1000 N of damping
  EXPECT_EQ(force(c, opening, 1e-4, 1e-5, xi).z, 0);
  c.least = -std::numeric_limits<double>::infinity();
  EXPECT_NEAR(force(c, opening, 1e-4, 1e-5, xi).z, 900, 1e-9);
}

// A ball on a plate, at eight places of the first contact within a step of the default length.
double largest_error_of_restitution(double restitution, double thickness) {
  dem::Physics physics;
  physics.materials = {{.name = "stone", .density = 2600, .young = 5e9}};
  dem::ContactLaw law{.first = "stone", .second = "stone"};
  law.kind = dem::LawKind::hertz, law.restitution = restitution;
  physics.laws = {law}, physics.thickness = thickness;
  dem::Parameters weightless;
  weightless.gravity = 0;
  dem::Domain domain = test::box(Vec3::Constant(-0.3), Vec3::Constant(0.3));
  if (thickness > 0) domain.dimension = Dimension::plane, domain.thickness = thickness;
  constexpr double r = 0.02, v = 1;  // m, m/s
  const dem::Template shape = thickness > 0 ? test::disk() : test::sphere();
  const double mass = 2600 * shape.volume * (thickness > 0 ? r * r * thickness : r * r * r);
  const double step = stable_step(physics, weightless, mass, r);
  double largest = 0;
  for (int place = 0; place < 8; ++place) {
    dem::Particles p(par::Comm::self(), physics, weightless, domain);
    p.add_template(shape);
    dem::NewParticle ball;
    ball.scale = r, ball.velocity = Vec3(0, 0, -v);
    ball.position.z() = r + (1 + place / 8.0) * v * step;
    p.add(std::span(&ball, 1));
    Surface plate = test::floor_of(1, 0.2);
    p.set_surfaces({&plate});
    p.advance(2000 * step, 2000);
    EXPECT_EQ(p.trouble(), "");
    largest = std::max(largest, std::abs(p[0].velocity.z() / v - restitution));
  }
  return largest;
}

// Without attraction the damping ratio of a law grows without limit as its restitution approaches
// 0; with steps of the spring alone a restitution of 0.001 was 5.3 in a plane.
TEST(ContactLaw, LowRestitutionIsResolvedByTheDefaultStep) {
  for (const double thickness : {0.0, 0.1})
    for (const double restitution : {0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 1e-3}) {
      // First order in the step; a Hertz contact in space begins softly. Largest at 0.2: 0.0071 in
      // space, 0.048 in a plane.
      EXPECT_LT(largest_error_of_restitution(restitution, thickness), thickness > 0 ? 0.06 : 0.01)
          << restitution << ", thickness " << thickness;
    }
}

}  // namespace
}  // namespace trackbed::dem::contact_law_test
