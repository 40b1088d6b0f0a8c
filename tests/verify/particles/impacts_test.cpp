// Oblique impacts of balls on a plate and on each other, against closed forms.
#include "impacts.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "dem/law/laws.hpp"
#include "support/verified.hpp"

namespace trackbed::impacts_test {
namespace {

using namespace impacts;

TEST(Impact, FrictionWhileSlidingIsMuOfTheNormalImpulse) {
  constexpr double mu = 0.6;
  const auto check = [&](const Ball& ball, double speed, const std::string& which) {
    const Motion before{{speed, 0, -0.5176}, Vec3::Zero()};
    const Motion after = impact(ball, before, 0.01 * contact_time(ball, 0.5176));
    const Vec3 change = after.velocity - before.velocity;
    verified::near("tangential over normal impulse, " + which, "-", -change.x() / change.z(), mu,
                   {1e-12, "slips from the first step, at the limit: rounding of 100 steps"});
  };
  // Slip ends exactly at the end of the collision if 7/2 mu (1 + e) v_n = v_t: e = 0.78.
  for (const double e : {0.1, 0.2, 0.35, 0.5, 0.7, 0.77})
    check({.restitution = e, .friction = mu}, 1.932, fmt::format("hertz, e = {:g}", e));
  for (const double zeta : {0.2, 0.5})
    check({.friction = mu, .hertz = false, .zeta = zeta}, 1.932,
          fmt::format("linear, zeta = {:g}", zeta));
  // With e = 1 it slips to the end for 2.174 m/s and more.
  check({.restitution = 1, .friction = mu}, 2.2, "hertz, e = 1");
  check({.friction = mu, .hertz = false, .zeta = 0}, 2.2, "linear, zeta = 0");
}

// Sliding throughout, with initial spin: v_t' = v_t - mu (1 + e) v_n,
// w' = w + 5/2 mu (1 + e) v_n / R (tests 4 to 6 of Chung, Ooi 2011,
// doi:10.1007/s10035-011-0277-0, beyond the end of sticking).
TEST(Impact, SlidingThroughoutFollowsItsClosedForm) {
  constexpr double mu = 0.092, v = 3.9;
  for (const double e : {0.2, 0.5, 0.8, 1.0})
    for (const double degrees : {45.0, 60.0, 85.0})
      for (const double spin : {0.0, -500.0}) {
        const Ball ball{380e9, 0.23, 4000, 2.5e-3, e, mu};
        const double a = degrees * M_PI / 180, down = v * std::cos(a), r = ball.radius;
        const Motion after = impact(ball, {{v * std::sin(a), 0, -down}, {0, spin, 0}},
                                    0.005 * contact_time(ball, down));
        const double change = mu * (1 + e) * down;
        const std::string at = fmt::format(", {:g} degrees, e = {:g}, spin {:g}", degrees, e, spin);
        const verified::Tolerance damped{
            1e-3, "restitution: first order, 0.2 of a step of 0.005 t_c over 1 + e"};
        const verified::Tolerance elastic{1e-10, "elastic, slips throughout: rounding"};
        verified::near("tangential velocity lost" + at, "m/s", v * std::sin(a) - after.velocity.x(),
                       change, (e < 1 ? damped : elastic).of(change));
        const verified::Tolerance shorter{
            depth(ball, down) / r + (e < 1 ? 1e-3 : 0),
            "lever arm shorter than R by at most the overlap, and the error of restitution"};
        const double turned = 2.5 * change / r;
        verified::near("spin gained" + at, "rad/s", after.spin.y() - spin, turned,
                       shorter.of(turned));
      }
}

// Head-on impacts, without attraction, that begin at any point of a step: largest and mean error of
// the restitution. The error is of first order in the step: the damping force uses the velocity of
// half a step before, and that of a linear law begins with a jump, which counts for a whole step
// (docs/decisions/contact_laws.md).
TEST(Impact, RestitutionErrorIsOfFirstOrderInTheStep) {
  constexpr int places = 40;
  constexpr double v = 0.5;
  struct Error {
    double largest = 0, mean = 0;
  };
  const auto error_of = [&](Ball ball, double e, double fraction) {
    Error error;
    for (int k = 0; k < places; ++k) {
      ball.place = (k + 0.5) / places;
      const Motion before{{0, 0, -v}, Vec3::Zero()};
      const Motion after = impact(ball, before, fraction * contact_time(ball, v));
      const double off = after.velocity.z() / v - e;
      error.largest = std::max(error.largest, std::abs(off)), error.mean += off / places;
    }
    return error;
  };
  for (const bool hertz : {false, true})
    for (const double e : {0.2, 0.5, 0.9}) {
      const Ball ball{.restitution = e, .hertz = hertz, .zeta = dem::linear_damping(e, true)};
      const Error coarse = error_of(ball, e, 0.02), fine = error_of(ball, e, 0.01),
                  finest = error_of(ball, e, 0.005);
      const std::string law = fmt::format("{}, e = {:g}", hertz ? "hertz" : "linear", e);
      // What damping takes from the speed in one step, w dt = 0.02 pi, of a speed of e v.
      const double step = 2 * ball.zeta * 0.02 * std::numbers::pi * e;
      const verified::Limit jump{std::min(step, 0.016),
                                 "the first damping counts for a whole step"};
      const verified::Limit late{step / 2, "damping of half a step before"};
      const verified::Limit& most = hertz ? late : jump;
      verified::below("largest error of restitution, step of 0.02 t_c, " + law, "-", coarse.largest,
                      most);
      verified::below(
          "mean error of restitution, step of 0.02 t_c, " + law, "-", std::abs(coarse.mean),
          {std::min(most.size, 0.006), "over the places in a step: less than the largest"});
      const verified::Tolerance first{0.06, "first order: 1/2; second order w dt = 0.06 of it"};
      const verified::Tolerance higher{
          0.2, "first order is small here, (1 - e)^2, beside second order, which has 1/4"};
      const verified::Tolerance& order = hertz && e > 0.6 ? higher : first;
      verified::near("ratio of largest errors, half the step over the step, " + law, "-",
                     fine.largest / coarse.largest, 0.5, order);
      verified::near("ratio of largest errors, a quarter of the step over half of it, " + law, "-",
                     finest.largest / fine.largest, 0.5, order);
      // The rows of docs/decisions/contact_laws.md.
      RecordProperty(law, fmt::format("{:.2g} {:.2g} {:.2g} {:.2g}", coarse.largest, fine.largest,
                                      coarse.mean, fine.mean));
    }
}

// Two balls that collide along x with spins about y: different spins, speeds and sizes (tests 7 and
// 8).
TEST(Impact, SpinningBallsOfDifferentSizesFollowTheClosedForm) {
  for (const double e : {0.3, 1.0})
    for (const double ratio : {1.0, 0.4})
      for (const double spin : {100.0, -250.0}) {
        const Ball ball{70e9, 0.33, 2700, 0.01, e, 0.1};
        const double r[] = {0.01, 0.01 * ratio}, v[] = {0.2, -0.1}, w[] = {spin, 0.5 * spin};
        dem::Particles p = nothing(ball);
        std::vector<dem::NewParticle> two(2);
        for (std::size_t k = 0; k < 2; ++k) {
          two[k].id = static_cast<Id>(k), two[k].scale = r[k];
          two[k].position.x() = (k ? 1 : -1) * (r[k] + 1e-8);
          two[k].velocity.x() = v[k], two[k].spin.y() = w[k];
        }
        p.add(two);
        p.advance(400e-6, 20000);
        ASSERT_EQ(p.totals().contacts, 0);
        const double m[] = {p[0].mass, p[1].mass};
        const double normal = m[0] * m[1] / (m[0] + m[1]) * (1 + e) * (v[0] - v[1]);
        // On the first, along -z for spins > 0, opposite to the motion of its surface.
        const double friction = 0.1 * normal * (spin > 0 ? 1 : -1);
        const std::string at = fmt::format(", size {:g}, e = {:g}, spin {:g}", ratio, e, spin);
        for (std::size_t k = 0; k < 2; ++k) {
          const double sign = k ? -1 : 1;
          const std::string which = fmt::format(" of ball {}", k + 1) + at;
          const verified::Tolerance turn{
              1e-3, "the line of centres turns by up to 1e-4 rad in the contact, over mu: 1e-3"};
          verified::near("tangential velocity" + which, "m/s", p[k].velocity.z(),
                         sign * friction / m[k], turn.of(friction / m[k]));
          const double turned = -2.5 * friction / (m[k] * r[k]);
          const verified::Tolerance arm{
              1e-3, "lever arm shorter than R by up to half the overlap, 4e-4 R; twice"};
          verified::near("spin gained" + which, "rad/s", p[k].spin.y() - w[k], turned,
                         arm.of(turned));
        }
      }
}

// Linear springs without slip: the contact point oscillates with 2/7 of the mass,
// u' = u cos(pi sqrt(3.5 k_s / k_n)) after the contact time pi sqrt(m / k_n).
TEST(Impact, LinearSpringsWithoutSlipOscillate) {
  const Ball ball{.friction = 1e6, .hertz = false};
  const double swing = std::cos(M_PI * std::sqrt(3.5 * 0.8));
  const verified::Tolerance arm{
      5e-3, "lever arm shorter than R by 3e-3 R: 0.012 rad of the oscillation, 3e-3 of the speed"};
  for (const double degrees : {5.0, 20.0, 45.0}) {
    const double along = 0.3 * std::tan(degrees * M_PI / 180);
    const Motion after =
        impact(ball, {{along, 0, -0.3}, Vec3::Zero()}, 2e-3 * contact_time(ball, 0.3));
    verified::near(fmt::format("tangential velocity without slip at {:g} degrees", degrees), "m/s",
                   after.velocity.x(), along * (1 + (swing - 1) / 3.5), arm.of(along));
  }
}

// All incidences, from sticking to sliding (Maw, Barber, Fawcett 1976; Kharaz, Gorham, Salman 2001,
// use these materials), against that integration.
TEST(Impact, ElasticImpactsFollowMindlinsIncrements) {
  for (const double degrees : {2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 45.0, 65.0, 85.0}) {
    const double a = degrees * M_PI / 180, v = 3.9;
    const Ball ball{380e9, 0.23, 4000, 2.5e-3, 1, 0.092};
    const Motion before{{v * std::sin(a), 0, -v * std::cos(a)}, Vec3::Zero()};
    const Motion measured = impact(ball, before, 0.002 * contact_time(ball, v * std::cos(a)));
    const Motion expected = by_increments(ball, before);
    const std::string at = fmt::format(" at {:g} degrees", degrees);
    const double scale = std::min(v * std::sin(a), 2 * ball.friction * v * std::cos(a));
    const verified::Tolerance sticks{2e-3, "no slip: first order, 2/3 of a step of 0.002 t_c"};
    const verified::Tolerance slips{
        4e-5, "slip removes the error; the rule in steps of 1e-5 of the collision: first order"};
    const verified::Tolerance& step = degrees < 10 ? sticks : slips;
    verified::near("tangential velocity" + at, "m/s", measured.velocity.x(), expected.velocity.x(),
                   step.of(scale));
    verified::near("spin" + at, "rad/s", measured.spin.y(), expected.spin.y(),
                   step.of(2.5 * scale / ball.radius));
  }
}

}  // namespace
}  // namespace trackbed::impacts_test
