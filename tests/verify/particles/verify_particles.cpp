// Particles against closed forms and published values.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/scene.hpp"
#include "support/verified.hpp"

namespace trackbed::verify_particles {
namespace {

struct Solid {
  double young, poisson, density;
};

dem::Physics hertz(const Solid& solid, double restitution, double friction, double wall = 1e30) {
  dem::Physics physics;
  dem::Material ball{
      .name = "ball", .density = solid.density, .young = solid.young, .poisson = solid.poisson};
  dem::Material plate{.name = "plate", .young = wall, .poisson = 0};
  physics.materials = {ball, plate};
  for (const char* second : {"ball", "plate"}) {
    dem::ContactLaw law{.first = "ball", .second = second, .kind = dem::LawKind::hertz};
    law.restitution = restitution, law.friction = friction;
    physics.laws.push_back(law);
  }
  return physics;
}

dem::Parameters weightless() {
  dem::Parameters p;
  p.gravity = 0, p.largest_overlap = 10;
  return p;
}

struct Course {
  double overlap = 0, force = 0, duration = 0;
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
};

// Runs until the contact opens again.
Course collide(dem::Particles& p, double dt) {
  Course course;
  bool collided = false;
  for (int step = 0; step < 2000000; ++step) {
    p.advance(dt, 1);
    const dem::Totals t = p.totals();
    if (t.contacts == 0 && collided) break;
    if (t.contacts == 0) continue;
    collided = true;
    course.duration += dt;
    course.overlap = std::max(course.overlap, t.largest_overlap);
    course.force = std::max(course.force, p[0].force.norm());
  }
  course.velocity = p[0].velocity, course.spin = p[0].spin;
  return course;
}

void check_course(const Course& course, const std::string& which, double overlap, double force,
                  double duration) {
  const verified::Tolerance four{2e-4, "four digits of the reference"};
  const verified::Tolerance five{1e-4, "digits of the reference, 0.5 N"};
  const verified::Tolerance step{7e-4, "a step, 1/1800 of the collision, and four digits"};
  verified::near("overlap" + which, "m", course.overlap, overlap, four.of(overlap));
  verified::near("force" + which, "N", course.force, force, five.of(force));
  verified::near("duration" + which, "s", course.duration, duration, step.of(duration));
}

TEST(Collision, TwoElasticHertzSpheres) {
  struct Case {
    Solid solid;
    double overlap, force, duration;
  };
  // d_max = (15 m* v^2 / (16 E* sqrt(R*)))^0.4, t_c = 2.943 d_max / v; v = 20 m/s, R = 10 mm.
  for (const Case& c : {Case{{48e9, 0.20, 2800}, 274.1e-6, 10.697e3, 40.34e-6},
                        Case{{20e9, 0.25, 2500}, 368.3e-6, 7.108e3, 54.20e-6}}) {
    dem::Particles p(par::Comm::self(), hertz(c.solid, 1, 0), weightless(),
                     test::box(Vec3::Constant(-1), Vec3::Ones()));
    p.add_template(test::sphere());
    std::vector<dem::NewParticle> two(2);
    for (int k = 0; k < 2; ++k) {
      two[static_cast<std::size_t>(k)].id = k;
      two[static_cast<std::size_t>(k)].scale = 0.01;
      two[static_cast<std::size_t>(k)].position = Vec3(k ? 0.01001 : -0.01001, 0, 0);
      two[static_cast<std::size_t>(k)].velocity = Vec3(k ? -10 : 10, 0, 0);
    }
    p.add(two);
    const Course course = collide(p, 2e-8);
    const std::string which = fmt::format(", {:g} GPa", c.solid.young * 1e-9);
    check_course(course, which, c.overlap, c.force, c.duration);
    verified::near("velocity afterwards" + which, "m/s", course.velocity.x(), -10,
                   {1e-10, "elastic, error of the step below 1e-20: rounding of 2000 steps"});
  }
}

// Impact of a sphere on a fixed plate below it.
Course impact(const dem::Physics& physics, double radius, const Vec3& velocity, double dt) {
  dem::Particles p(par::Comm::self(), physics, weightless(),
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = radius, one.velocity = velocity, one.position = Vec3(0, 0, radius + 0.5 * dt);
  p.add(std::span(&one, 1));
  Surface plate = test::floor_of(1, 1.9);
  plate.material = 1;
  p.set_surfaces({&plate});
  return collide(p, dt);
}

TEST(Collision, ElasticHertzSphereOnARigidPlane) {
  struct Case {
    Solid solid;
    double overlap, force, duration;
  };
  for (const Case& c : {Case{{70e9, 0.30, 2699}, 49.72e-6, 11.370e3, 0.7316e-3},
                        Case{{40e9, 0.35, 1800}, 52.12e-6, 7.233e3, 0.7671e-3}}) {
    const Course course = impact(hertz(c.solid, 1, 0), 0.1, Vec3(0, 0, -0.2), 4e-7);
    check_course(course, fmt::format(", {:g} GPa", c.solid.young * 1e-9), c.overlap, c.force,
                 c.duration);
  }
}

// See Impact.RestitutionErrorIsOfFirstOrderInTheStep; the step is 3.3e-4 of the collision.
TEST(Restitution, HertzGivesTheSpecifiedValue) {
  const verified::Tolerance damped{2e-4, "first order: 0.3 of a step of 3.3e-4 t_c, twice"};
  const verified::Tolerance elastic{1e-10, "elastic: rounding of 3000 steps"};
  for (const double e : {0.2, 0.4, 0.6, 0.8, 0.98, 1.0}) {
    const Course course = impact(hertz({380e9, 0.23, 4000}, e, 0), 2.5e-3, Vec3(0, 0, -3.9), 2e-9);
    verified::near(fmt::format("v'/v for e = {:g}", e), "-", course.velocity.z() / 3.9, e,
                   e < 1 ? damped : elastic);
  }
}

TEST(Restitution, LinearFollowsItsClosedForm) {
  // With attraction e = exp(-pi zeta / sqrt(1 - zeta^2)); without it the collision ends when the
  // force vanishes (Schwager, Poeschel 2007, doi:10.1007/s10035-007-0065-z).
  const auto measured = [](double zeta, bool attraction) {
    dem::Physics physics = test::one_material({}, 4000);
    physics.materials.push_back({.name = "plate"});
    dem::ContactLaw law{.first = "stone", .second = "plate", .zeta_n = zeta};
    law.k_n = 1e6, law.friction = 0, law.attraction = attraction;
    physics.laws.push_back(law);
    return impact(physics, 2.5e-3, Vec3(0, 0, -3.9), 2e-8).velocity.z() / 3.9;
  };
  const auto cut = [](double zeta) {
    const double root = std::sqrt(1 - zeta * zeta);
    return std::exp(-zeta / root * (M_PI - std::atan2(2 * zeta * root, 1 - 2 * zeta * zeta)));
  };
  const verified::Tolerance damped{3e-4, "first order: 0.7 of a step of 3.9e-4 t_c"};
  const verified::Tolerance elastic{1e-10, "elastic: rounding of 3000 steps"};
  verified::near("e for zeta = 0.25", "-", measured(0.25, true), 0.44434, damped);
  verified::near("e for zeta = 0.45595", "-", measured(0.45595, true), 0.2, damped);
  for (const double zeta : {0.0, 0.1, 0.25, 0.45595})
    verified::near(fmt::format("e without attraction, zeta = {:g}", zeta), "-",
                   measured(zeta, false), cut(zeta), zeta > 0 ? damped : elastic);
}

TEST(Collision, ObliqueImpact) {
  struct Case {
    double degrees, restitution, spin;
  };
  // The overlap grows with the normal velocity to the power 4/5.
  const verified::Tolerance shorter{
      3.3e-3, "lever arm: shorter than R by at most the overlap, 3.2e-3 R at 3.9 m/s"};
  // Digitised from Chung, Ooi 2011 (doi:10.1007/s10035-011-0277-0), accurate to 3 %. Where the
  // contact sticks, below 15 degrees, the curve is that of another law of the spring, F = k xi,
  // which generates energy: at 10 degrees it differs by 8 %, at 5 degrees (0.948, -19.3 rad/s) it
  // is no reference. For the present law in this range see impacts_test
  // (docs/decisions/contact_laws.md).
  const double v = 3.9, mu = 0.092, e = 0.98, r = 2.5e-3;
  for (const Case& c : {Case{10, 0.687, -213}, Case{15, 0.624, -378}, Case{20, 0.616, -511},
                        Case{25, 0.634, -599}, Case{30, 0.684, -617}, Case{40, 0.781, -545},
                        Case{60, 0.893, -357}, Case{80, 0.966, -126}}) {
    const double a = c.degrees * M_PI / 180;
    const Course course = impact(hertz({380e9, 0.23, 4000}, e, mu), r,
                                 Vec3(v * std::sin(a), 0, -v * std::cos(a)), 4e-9);
    const double kept = course.velocity.x() / (v * std::sin(a));
    const double turn = -course.spin.y();  // the source has the opposite sign
    const verified::Tolerance digitised{0.035, "digitised from a figure: 3 %, and its line"};
    const std::string at = fmt::format(" at {:g} degrees", c.degrees);
    const bool sticks = c.degrees < 15;
    verified::near("tangential restitution" + at, "-", kept, c.restitution,
                   digitised.of(sticks ? 1 : c.restitution));
    verified::near("spin" + at, "rad/s", turn, c.spin, digitised.of(sticks ? 620 : c.spin));
    if (c.degrees <= 30) continue;  // sliding throughout: closed form
    verified::near(
        "restitution, closed form," + at, "-", kept, 1 - mu * (1 + e) / std::tan(a),
        {1e-5, "restitution: first order, 2e-5 in this step, times mu / tan a, 4 times"});
    const double closed = -5 * mu * (1 + e) * v * std::cos(a) / (2 * r);
    verified::near("spin, closed form," + at, "rad/s", turn, closed,
                   shorter.of(std::pow(std::cos(a), 0.8) * closed));
  }
}

dem::ContactLaw linear(double friction) {
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e6;
  law.friction = friction, law.zeta_n = law.zeta_s = 0.3;
  return law;
}

TEST(Friction, SlipTurnsIntoRolling) {
  dem::Particles p(par::Comm::self(), test::one_material(linear(0.3)), {},
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  const double r = 0.02, v0 = 1;
  dem::NewParticle one;
  one.scale = r, one.velocity = Vec3(v0, 0, 0);
  const double mass = 2500 * test::sphere().volume * r * r * r;
  one.position = Vec3(-1.5, 0.3, r - mass * gravity / 1e6);
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(9, 1.9);
  p.set_surfaces({&floor});
  const double rolls = 2 * v0 / (7 * 0.3 * gravity), dt = 1e-5;
  double began = 0;
  for (int k = 0; k < 2000 && began == 0; ++k) {
    p.advance(10 * dt, 10);
    if (std::abs(p[0].velocity.x() - p[0].spin.y() * r) < 1e-3 * v0) began = (k + 1) * 10 * dt;
  }
  verified::near("start of rolling", "s", began, rolls,
                 {2e-4, "sampled every 0.1 ms; slip of 1e-3 v0 counts as rolling, 0.1 ms early"});
  verified::near("velocity when rolling", "m/s", p[0].velocity.x(), 5.0 / 7.0 * v0,
                 {3e-4 * v0, "2/7 of the remaining slip, at most 1e-3 v0"});
}

TEST(Friction, ABlockSlipsExactlyBeyondItsAngle) {
  const auto slides = [](double tangent) {
    dem::Particles p(par::Comm::self(), test::one_material(linear(0.5)), {},
                     test::box(Vec3::Constant(-2), Vec3::Constant(2)));
    dem::Template block;  // four feet, low and wide
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0}) block.pieces.push_back(geom::ball({x, y, 0}, 0.3));
    block.volume = 1, block.gyration = Vec3(1, 1, 2);
    p.add_template(block);
    const double angle = std::atan(tangent);
    const Quat tilt(Eigen::AngleAxisd(angle, Vec3::UnitY()));
    Surface floor = test::floor_of(3, 1);
    for (Vec3& x : floor.position) x = tilt * x;
    dem::NewParticle one;
    one.scale = 0.05, one.attitude = tilt, one.position = tilt * Vec3(0, 0, 0.015);
    p.add(std::span(&one, 1));
    p.set_surfaces({&floor});
    p.set_local_damping(0.3);
    p.advance(0.1, 20000);
    p.set_local_damping(-1);
    const Vec3 before = p[0].position;
    p.advance(0.1, 20000);
    return (p[0].position - before).norm();
  };
  verified::below("displacement of the block in 0.1 s, tan a = 0.98 mu", "m", slides(0.49),
                  {1e-13, "holds: rounding of a place of 15 mm, 2e-18 m, in 2e4 steps"});
  const double a = std::atan(0.51);
  const double free = 0.5 * gravity * (std::sin(a) - 0.5 * std::cos(a)) * 0.01;
  verified::above("displacement of the block in 0.1 s, tan a = 1.02 mu", "m", slides(0.51),
                  {free, "slips with an initial velocity: more than from rest"});
}

// Largest energy error over many bounces at dt = fraction * sqrt(m/k), over the energy.
double bounce_error(double fraction) {
  dem::Physics physics = test::one_material(linear(0));
  physics.laws[0].zeta_n = physics.laws[0].zeta_s = 0;
  dem::Particles p(par::Comm::self(), physics, {},
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = 0.02, one.position = Vec3(0, 0, 0.12);
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(2, 1);
  p.set_surfaces({&floor});
  const auto energy = [&] {
    const dem::Totals t = p.totals();
    return t.kinetic + t.potential + t.elastic;
  };
  const double before = energy(), dt = fraction * std::sqrt(p[0].mass / 1e6);
  double error = 0;
  for (int k = 0; k < 100; ++k) {
    p.advance(0.025, static_cast<int>(0.025 / dt));
    error = std::max(error, std::abs(energy() - before) / before);
  }
  return error;
}

TEST(Energy, ADroppedBallReboundsToItsHeight) {
  // A contact opens and closes between two steps. The law corrects the error of the spring,
  // (dt w)^2 / 8, but not that of the weight, which is 2e-3 of the largest force.
  const double coarse = bounce_error(0.1), middle = bounce_error(0.035),
               fine = bounce_error(0.0125);
  const verified::Limit ends{2e-2, "nine bounces: (dt w)^3 times weight over force, 2e-3, each"};
  verified::below("energy error at dt = 0.1 sqrt(m/k)", "-", coarse, ends.of(1e-3));
  verified::below("energy error at dt = 0.0125 sqrt(m/k)", "-", fine, ends.of(std::pow(0.0125, 3)));
  verified::near("order in dt, 0.1 to 0.0125 sqrt(m/k)", "-",
                 std::log(coarse / fine) / std::log(8.0), 3,
                 {0.3, "third order; places of bounces in a step change the sum by up to half"});
  verified::near("order in dt, 0.1 to 0.035 sqrt(m/k)", "-",
                 std::log(coarse / middle) / std::log(0.1 / 0.035), 3,
                 {1, "third order; places of bounces in a step change the sum by up to half"});
}

}  // namespace
}  // namespace trackbed::verify_particles
