// A ball between two plates, without gravity and damping: it bounces without end, and friction and
// the tangential spring must not increase its energy, for any size, stiffness, speed and gap
// between the plates, which determines at which point of a step each contact begins. The
// environment variable TRACKBED_BOUNCES sets a larger number of bounces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>

#include "support/scene.hpp"
#include "support/verified.hpp"

namespace trackbed::bounces_test {
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

// Step over the contact time, and gap between plates and ball over the distance travelled in a
// contact time.
struct Course {
  double step = 0.02, gap = 1;
  int bounces = 200;
};

struct Errors {
  double rise = 0;  // largest increase above the least earlier energy, over the first
  double rms = 0;   // of the changes from bounce to bounce, over the first
};

double kinetic(const Ball& b, const dem::ParticleView& p) {
  return 0.5 * p.mass *
         (p.velocity.squaredNorm() + 0.4 * b.radius * b.radius * p.spin.squaredNorm());
}

Errors bounced(const Ball& ball, const Course& course) {
  const double time = ball.contact_time(), gap = course.gap * ball.speed * time;
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
  // Windows that ten times the usual flights and contacts take; a ball that sticks needs more.
  const double longest = 10 * course.bounces * (course.gap + 2) / (stride * course.step) + 10;
  int windows = 0;
  for (bool up = false; done < course.bounces;) {
    if (++windows > longest || !p.trouble().empty()) {
      ADD_FAILURE() << "only " << done << " bounces; " << p.trouble();
      break;
    }
    p.advance(stride * course.step * time, stride);
    const double z = p[0].position.z();
    if ((p[0].velocity.z() > 0) == up || z < ball.radius || z > ball.radius + gap) continue;
    // It is in free flight in the opposite direction.
    const double now = kinetic(ball, p[0]);
    errors.rise = std::max(errors.rise, now - least), least = std::min(least, now);
    squares += (now - last) * (now - last), last = now;
    up = !up, ++done;
  }
  errors.rise /= first, errors.rms = std::sqrt(squares / done) / first;
  return errors;
}

int bounces_or(int usual) {
  const char* given = std::getenv("TRACKBED_BOUNCES");
  return given ? std::atoi(given) : usual;
}

// The limits are also those of the study, whose figures are in docs/decisions/contact_laws.md.
const verified::Limit ends{
    6e-10, "ends of contacts of 50 steps, 5e-11 of either sign: 3e-10 in 1e4 bounces, twice"};
const verified::Limit rounded{
    5e-9, "rounding of places, 1e-16 R, in overlaps from 2e-5 R: 2.5e-9 in 1e4 bounces, twice"};

// Verifies the largest rise over `gaps` gaps between the plates, distributed over two and a half
// distances of a contact time.
void expect_no_rise(const Ball& ball, int gaps, int bounces, const std::string& which,
                    const verified::Limit& limit) {
  double rise = 0;
  for (int k = 0; k < gaps; ++k) {
    const double gap = 0.5 + 2 * std::fmod((k + 0.5) * std::numbers::phi, 1.0);
    rise = std::max(rise, bounced(ball, {.gap = gap, .bounces = bounces}).rise);
  }
  verified::below(fmt::format("rise of energy in {} bounces, {} gaps, {}", bounces, gaps, which),
                  "of the first", rise, limit);
}

TEST(Bounces, NeverRaiseTheEnergy) {
  for (const bool hertz : {true, false})
    for (const double poisson : {0.1, 0.25, 0.4})
      for (const double friction : {0.0, 0.3, 0.7, 5.0}) {
        if (!hertz && poisson > 0.1) continue;  // not used by the linear law
        expect_no_rise(
            {.hertz = hertz, .poisson = poisson, .friction = friction}, 3, bounces_or(300),
            fmt::format("{}, friction {:g}",
                        hertz ? fmt::format("hertz, nu {:g}", poisson) : "linear", friction),
            ends);
      }
}

// When a contact opens, its tangential spring is still stretched, depending on its period and on
// friction: near 2/7 k_n its force is zero within the last steps (`remaining` in contact.hpp).
TEST(Bounces, OfAnyTangentialStiffnessNeverRaiseTheEnergy) {
  const verified::Limit remaining{
      5e-8, "slip in the last steps near 2/7 k_n: up to 2.7e-8 in 1e4 bounces"};
  for (const double k_s : {0.25, 2.0 / 7, 0.29, 0.5, 0.8, 1.2, 2.0})
    for (const double friction : {0.1, 0.3, 1.5, 5.0})
      for (const double spin : {-0.05, -1.0, 0.7})
        expect_no_rise(
            {.hertz = false, .friction = friction, .k_s = k_s, .spin = spin}, 4, bounces_or(200),
            fmt::format("linear, k_s {:.3g} k_n, friction {:g}, spin {:g}", k_s, friction, -spin),
            remaining);
}

// The lever arm of friction changes from step to step as the overlap grows; near 8/7 k_n the
// tangential spring completes one oscillation in a contact, and an energy error of a step would
// recur in each bounce.
TEST(Bounces, ThatSpinFastNeverRaiseTheEnergy) {
  const verified::Limit arms{
      1e-9, "lever arms of half a step: 4.7e-10, which does not grow in 1e4 bounces, twice"};
  for (const double k_s : {0.8, 8.0 / 7, 1.2})
    for (const double spin : {-3.0, 1.76})
      expect_no_rise(
          {.hertz = false, .friction = 1.5, .k_s = k_s, .spin = spin}, 4, bounces_or(200),
          fmt::format("linear, k_s {:.3g} k_n, friction 1.5, spin {:g}", k_s, -spin), arms);
}

// Overlaps of 1.2 % of the radius.
TEST(Bounces, ThatAreFastNeverRaiseTheEnergy) {
  const verified::Limit arms{
      1e-6, "lever arms change by 5e-4 in a step: 4e-11 a bounce, 3.6e-7 in 1e4, three times"};
  for (const double k_s : {1.11, 8.0 / 7})
    expect_no_rise({.hertz = false, .friction = 5, .speed = 1.2, .k_s = k_s, .spin = 1.76}, 4,
                   bounces_or(200), fmt::format("linear, 1.2 m/s, k_s {:.3g} k_n", k_s), arms);
}

// With a stiffness of 0.4 k_n half a period of a sphere's rolling spring, which friction does not
// affect, is as long as the contact.
TEST(Bounces, ThatRollNeverRaiseTheEnergy) {
  const verified::Limit springs{
      1e-10, "rolling springs where contacts open: 3.2e-11 in 1e4 bounces, three times"};
  for (const double friction : {0.0, 0.7})
    for (const double stiffness : {0.1, 0.4, 1.0})
      for (const double rolling : {0.2, 1.0})
        expect_no_rise(
            {.hertz = false,
             .friction = friction,
             .spin = -1,
             .rolling_friction = rolling,
             .rolling_stiffness = stiffness},
            4, bounces_or(200),
            fmt::format("linear, friction {:g}, rolling friction {:g}, stiffness {:g} k_n",
                        friction, rolling, stiffness),
            springs);
}

TEST(Bounces, OfAnySizeStiffnessAndSpeedNeverRaiseTheEnergy) {
  for (const double radius : {1e-3, 0.1})
    for (const double young : {1e8, 3e11})
      for (const double speed : {0.01, 1.0})
        expect_no_rise({.radius = radius, .young = young, .speed = speed}, 16, bounces_or(100),
                       fmt::format("R {:g} m, E {:g} Pa, {:g} m/s", radius, young, speed), rounded);
}

// Two balls that collide in 50 steps of contact, after `steps` steps of flight.
struct Collision {
  Ball large{};
  double ratio = 1;   // radius of the second over that of the first
  double offset = 0;  // of the centres across the velocity, over the sum of the radii
  double steps = 2;

  Ball small() const {
    Ball b = large;
    b.radius *= ratio;
    return b;
  }
  double contact_time() const {
    const double mass = large.mass() * small().mass() / (large.mass() + small().mass());
    if (!large.hertz) return std::numbers::pi * std::sqrt(mass / k_n);
    const double radius = large.radius * ratio / (1 + ratio), speed = 2 * large.speed;
    const double e_star = large.young / (2 * (1 - large.poisson * large.poisson));
    const double depth =
        std::pow(15 * mass * speed * speed / (16 * e_star * std::sqrt(radius)), 0.4);
    return 2.943 * depth / speed;
  }
};

// Relative change of the energy.
double energy_change(const Collision& c) {
  const double dt = 0.02 * c.contact_time(), small = c.small().radius;
  const double reach = c.large.radius + small, across = c.offset * reach;
  const double gap = std::sqrt(reach * reach - across * across) - reach;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(par::Comm::self(), physics_of(c.large), parameters,
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::sphere());
  std::vector<dem::NewParticle> two(2);
  two[1].id = 1;
  two[0].scale = c.large.radius, two[0].position.x() = -c.large.radius;
  two[1].scale = small, two[1].position = {small + gap, across, 0};
  two[0].velocity.x() = c.large.speed, two[1].velocity.x() = -c.large.speed;
  for (dem::NewParticle& ball : two) ball.position -= c.steps * dt * ball.velocity;
  p.add(two);
  const double before = p.totals().kinetic;
  p.advance(100 * dt, 100);
  EXPECT_EQ(p.totals().contacts, 0);
  EXPECT_LT(p[0].velocity.x(), two[0].velocity.x());
  return p.totals().kinetic / before - 1;
}

// Of 64 collisions that begin at different points of a step.
double largest_energy_change(Collision c) {
  double most = 0;
  for (int k = 0; k < 64; ++k) {
    c.steps = 2 + k / 64.0;
    most = std::max(most, std::abs(energy_change(c)));
  }
  return most;
}

TEST(Bounces, OfTwoBallsKeepTheEnergy) {
  // With k = 0 they touch at the end of a step, and rounding decides whether in that step.
  const verified::Limit ends{
      5e-11, "where rounding decides in which step they touch: 2.6e-11, twice; else 3e-12"};
  for (const double ratio : {1.0, 0.3})
    verified::below(fmt::format("change of energy in a collision, sizes 1 and {:g}", ratio),
                    "of the first", largest_energy_change({.ratio = ratio}), ends);
}

// The line of centres of an oblique collision turns while the balls are in contact. The linear law
// allows for it in the first and the last step; without that the energy changes by up to 5.4e-7,
// the square of the turn of one step, 3.6 m/s times 4.5 us over 20 mm = 8e-4.
TEST(Bounces, ThatAreObliqueKeepTheEnergy) {
  const verified::Limit turn{1e-9, "cube of the turn in a step, 8e-4 rad: 5e-10, twice"};
  const Ball ball{.hertz = false, .friction = 0, .speed = 2};
  for (const double ratio : {1.0, 0.3})
    for (const double offset : {0.3, 0.6, 0.9})
      verified::below(
          fmt::format("change of energy, sizes 1 and {:g}, centres {:g} off", ratio, offset),
          "of the first", largest_energy_change({.large = ball, .ratio = ratio, .offset = offset}),
          turn);
}

// The neglected terms at the ends of a Hertz contact are of third order in the fraction of the
// speed that the first force changes in a step, and that fraction grows as step^2.5: order 7.5. The
// means of 2000 collisions give 7.3 from 10 to 20 steps and 6.6 from 20 to 28; why the order falls
// is not known. With 40 steps the error is near rounding.
TEST(Bounces, ErrorOfAHertzCollisionFallsWithAboutTheSeventhOrder) {
  const Ball ball{.friction = 0};
  const auto error = [&](double step) {
    return bounced(ball, {.step = step, .gap = 1 + std::numbers::phi, .bounces = 2000}).rms;
  };
  const double coarse = error(0.1), middle = error(0.05), fine = error(0.05 / std::numbers::sqrt2);
  const verified::Tolerance order{1, "7.5 from the ends of contacts alone; falls to 6.6"};
  verified::near("order of the energy error of a collision, 10 to 20 steps", "-",
                 std::log2(coarse / middle), 7.5, order);
  verified::near("order of the energy error of a collision, 20 to 28 steps", "-",
                 2 * std::log2(middle / fine), 7.5, order);
  verified::below("energy error of a collision of 20 steps", "-", middle,
                  {5e-9, "guards the factor beside the order: twice 2.4e-9"});
}

}  // namespace
}  // namespace trackbed::bounces_test
