// A ball between two plates, without gravity and damping: it bounces for ever, and friction and the
// tangential spring must not give it energy, whatever its size, stiffness, speed and way between
// the plates, which sets where in a step each contact begins. TRACKBED_BOUNCES asks for more than
// the usual bounces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>

#include "support/scene.hpp"
#include "support/verified.hpp"

namespace trackbed {
namespace {

constexpr double density = 2500, k_n = 1e6;

struct Ball {
  bool hertz = true;
  double radius = 0.01, young = 70e9, poisson = 0.25, friction = 0.7, speed = 0.2;
  double k_s = 0.8;     // over k_n, of linear springs
  double spin = -0.05;  // speed of its surface over that of the ball
  double rolling_friction = 0, rolling_stiffness = 1;
  double mass() const { return density * test::sphere().volume * std::pow(radius, 3); }
  double contact_time() const {
    if (!hertz) return std::numbers::pi * std::sqrt(mass() / k_n);
    const double e_star = young / (2 * (1 - poisson * poisson));
    const double depth =
        std::pow(15 * mass() * speed * speed / (16 * e_star * std::sqrt(radius)), 0.4);
    return 2.943 * depth / speed;
  }
};

dem::Physics physics_of(const Ball& b) {
  dem::Physics physics;
  physics.materials = {
      {.name = "ball", .density = density, .young = b.young, .poisson = b.poisson}};
  dem::ContactLaw law{.first = "ball", .second = "ball"};
  law.kind = b.hertz ? dem::LawKind::hertz : dem::LawKind::linear;
  law.k_n = k_n, law.k_s = b.k_s * k_n, law.friction = b.friction;
  law.rolling_friction = b.rolling_friction, law.rolling_stiffness = b.rolling_stiffness;
  physics.laws = {law};
  return physics;
}

// `step` and `way` between the plates beside the ball, over the time of a contact and over the way
// of a contact time.
struct Course {
  double step = 0.02, way = 1;
  int bounces = 200;
};

struct Errors {
  double rise = 0;  // largest, above any earlier value, over the first
  double rms = 0;   // of the changes from bounce to bounce, over the first
};

double kinetic(const Ball& b, const dem::ParticleView& p) {
  return 0.5 * p.mass *
         (p.velocity.squaredNorm() + 0.4 * b.radius * b.radius * p.spin.squaredNorm());
}

Errors bounced(const Ball& ball, const Course& course) {
  const double time = ball.contact_time(), gap = course.way * ball.speed * time;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(
      par::Comm::self(), physics_of(ball), parameters,
      test::box(Vec3::Constant(-150 * ball.radius), Vec3::Constant(150 * ball.radius)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = ball.radius, one.velocity.z() = -ball.speed;
  one.spin.y() = ball.spin * ball.speed / ball.radius;
  one.position.z() = ball.radius + 0.5 * gap;
  p.add(std::span(&one, 1));
  const double side = 100 * ball.radius;
  Surface low = test::floor_of(1, side),
          high = test::floor_of(1, side, 2 * ball.radius + gap, "top");
  for (auto& t : high.triangles) std::swap(t[1], t[2]);
  p.set_surfaces({&low, &high});
  const double first = kinetic(ball, p[0]);
  double least = first, last = first, squares = 0;
  Errors errors;
  constexpr int stride = 8;  // sub-steps, fewer than any flight has
  int done = 0;
  for (bool up = false; done < course.bounces;) {
    p.advance(stride * course.step * time, stride);
    const double z = p[0].position.z();
    if ((p[0].velocity.z() > 0) == up || z < ball.radius || z > ball.radius + gap) continue;
    // It flies, and the other way than before.
    const double now = kinetic(ball, p[0]);
    errors.rise = std::max(errors.rise, now - least), least = std::min(least, now);
    squares += (now - last) * (now - last), last = now;
    up = !up, ++done;
  }
  errors.rise /= first, errors.rms = std::sqrt(squares / done) / first;
  return errors;
}

int bounces_or(int usual) {
  const char* asked = std::getenv("TRACKBED_BOUNCES");
  return asked ? std::atoi(asked) : usual;
}

// A row for the largest of `ways` ways between the plates, spread over two and a half flights of a
// contact time.
void never_rises(const Ball& ball, int ways, int bounces, const std::string& which,
                 double tolerance = 5e-9) {
  double rise = 0;
  for (int k = 0; k < ways; ++k) {
    const double way = 0.5 + 2 * std::fmod((k + 0.5) * std::numbers::phi, 1.0);
    rise = std::max(rise, bounced(ball, {.way = way, .bounces = bounces}).rise);
  }
  // Twice the 2.5e-9 that 1e4 bounces of the hardest and slowest of these balls give, whose
  // overlap is 3e-5 of the radius, so that its rounding counts; 3e-10 of the others.
  verified::below(fmt::format("rise of energy in {} bounces, {} ways, {}", bounces, ways, which),
                  "of the first", rise, tolerance);
}

TEST(Bounces, NeverRaiseTheEnergy) {
  for (const bool hertz : {true, false})
    for (const double poisson : {0.1, 0.25, 0.4})
      for (const double friction : {0.0, 0.3, 0.7, 5.0}) {
        if (!hertz && poisson > 0.1) continue;  // is of no account
        never_rises(
            {.hertz = hertz, .poisson = poisson, .friction = friction}, 3, bounces_or(300),
            fmt::format("{}, friction {:g}",
                        hertz ? fmt::format("hertz, nu {:g}", poisson) : "linear", friction));
      }
}

// Where a contact opens its tangential spring is stretched still, by what its period and friction
// have left: near 2/7 k_n it passes zero within the last steps (`remaining` in contact.hpp).
TEST(Bounces, OfAnyTangentialStiffnessNeverRaiseTheEnergy) {
  for (const double k_s : {0.25, 2.0 / 7, 0.29, 0.5, 0.8, 1.2, 2.0})
    for (const double friction : {0.1, 0.3, 1.5, 5.0})
      for (const double spin : {-0.05, -1.0, 0.7})
        never_rises(
            {.hertz = false, .friction = friction, .k_s = k_s, .spin = spin}, 4, bounces_or(200),
            fmt::format("linear, k_s {:.3g} k_n, friction {:g}, spin {:g}", k_s, friction, -spin),
            5e-8);
}

// The arm of friction changes from step to step as the ball comes in; near 8/7 k_n the tangential
// spring swings once in a contact, and what a step has too much is won in each bounce.
TEST(Bounces, ThatSpinFastNeverRaiseTheEnergy) {
  for (const double k_s : {0.8, 8.0 / 7, 1.2})
    for (const double spin : {-3.0, 1.76})
      never_rises({.hertz = false, .friction = 1.5, .k_s = k_s, .spin = spin}, 4, bounces_or(200),
                  fmt::format("linear, k_s {:.3g} k_n, friction 1.5, spin {:g}", k_s, -spin));
}

// Overlaps of 1.2 % of the radius.
TEST(Bounces, ThatAreFastNeverRaiseTheEnergy) {
  for (const double k_s : {1.11, 8.0 / 7})
    never_rises({.hertz = false, .friction = 5, .speed = 1.2, .k_s = k_s, .spin = 1.76}, 4,
                bounces_or(200), fmt::format("linear, 1.2 m/s, k_s {:.3g} k_n", k_s), 1e-6);
}

// With a stiffness of 0.4 k_n half a swing of a sphere's rolling spring, which friction does not
// disturb, takes as long as the contact.
TEST(Bounces, ThatRollNeverRaiseTheEnergy) {
  for (const double friction : {0.0, 0.7})
    for (const double stiffness : {0.1, 0.4, 1.0})
      for (const double rolling : {0.2, 1.0})
        never_rises({.hertz = false,
                     .friction = friction,
                     .spin = -1,
                     .rolling_friction = rolling,
                     .rolling_stiffness = stiffness},
                    4, bounces_or(200),
                    fmt::format("linear, friction {:g}, rolling friction {:g}, stiffness {:g} k_n",
                                friction, rolling, stiffness));
}

TEST(Bounces, OfAnySizeStiffnessAndSpeedNeverRaiseTheEnergy) {
  for (const double radius : {1e-3, 0.1})
    for (const double young : {1e8, 3e11})
      for (const double speed : {0.01, 1.0})
        never_rises({.radius = radius, .young = young, .speed = speed}, 16, bounces_or(100),
                    fmt::format("R {:g} m, E {:g} Pa, {:g} m/s", radius, young, speed));
}

// Relative change of the energy of two balls of unlike sizes that meet head on, in 50 steps of
// contact, after `way` steps.
double met(double ratio, double way) {
  const Ball large, small{.radius = ratio * large.radius};
  const double speed = 2 * large.speed, e_star = large.young / (2 * (1 - 0.25 * 0.25));
  const double mass = large.mass() * small.mass() / (large.mass() + small.mass());
  const double radius = large.radius * small.radius / (large.radius + small.radius);
  const double depth = std::pow(15 * mass * speed * speed / (16 * e_star * std::sqrt(radius)), 0.4);
  const double dt = 0.02 * 2.943 * depth / speed;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(par::Comm::self(), physics_of(large), parameters,
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::sphere());
  std::vector<dem::NewParticle> two(2);
  two[1].id = 1;
  two[0].scale = large.radius, two[0].position.x() = -large.radius - way * large.speed * dt;
  two[1].scale = small.radius, two[1].position.x() = small.radius + way * large.speed * dt;
  two[0].velocity.x() = large.speed, two[1].velocity.x() = -large.speed;
  p.add(two);
  const double before = p.totals().kinetic;
  p.advance(100 * dt, 100);
  EXPECT_EQ(p.totals().contacts, 0);
  EXPECT_LT(p[0].velocity.x(), two[0].velocity.x());
  return p.totals().kinetic / before - 1;
}

TEST(Bounces, OfTwoBallsKeepTheEnergy) {
  for (const double ratio : {1.0, 0.3}) {
    double most = 0;
    for (int k = 0; k < 64; ++k) most = std::max(most, std::abs(met(ratio, 2 + k / 64.0)));
    // Twice what a collision of 50 steps gives. k = 0: they touch at the end of a step, and
    // rounding says whether in it.
    verified::below(fmt::format("change of energy in a collision, sizes 1 and {:g}", ratio),
                    "of the first", most, 5e-11);
  }
}

// What is left out at the ends of a Hertz contact is of the third power of the share of its speed
// that the first force takes in a step, and that share grows as step^2.5.
TEST(Bounces, ErrorOfAHertzCollisionIsOfOrderSevenAndAHalf) {
  const Ball ball{.friction = 0};
  const auto error = [&](double step) {
    return bounced(ball, {.step = step, .way = 1 + std::numbers::phi, .bounces = 200}).rms;
  };
  const double coarse = error(0.1), fine = error(0.05);
  verified::near("order of the energy error of a collision", "-", std::log2(coarse / fine), 7.5,
                 0.15);
  verified::below("energy error of a collision of 20 steps", "-", fine, 5e-9);
}

}  // namespace
}  // namespace trackbed
