// Oblique impacts, bounces without end and loops of tangential load, against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/scene.hpp"
#include "support/verified.hpp"

namespace trackbed {
namespace {

struct Ball {
  double young = 1e9, poisson = 0.27, density = 2500, radius = 0.02;
  double restitution = 1, friction = 0;
  bool hertz = true;
};

// One material, and a second that makes a rigid plate.
dem::Physics physics_of(const Ball& b) {
  dem::Physics physics;
  physics.materials = {
      {.name = "ball", .density = b.density, .young = b.young, .poisson = b.poisson},
      {.name = "plate", .young = 1e30, .poisson = 0}};
  for (const char* second : {"ball", "plate"}) {
    dem::ContactLaw law{.first = "ball", .second = second};
    law.kind = b.hertz ? dem::LawKind::hertz : dem::LawKind::linear;
    law.restitution = b.restitution, law.friction = b.friction;
    law.k_n = 1e6, law.k_s = 8e5;
    physics.laws.push_back(law);
  }
  return physics;
}

dem::Particles nothing(const Ball& ball) {
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(par::Comm::self(), physics_of(ball), parameters,
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  return p;
}

struct Motion {
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
};

// Until it parts from the plate z = 0.
Motion thrown(const Ball& ball, const Motion& before, double dt) {
  dem::Particles p = nothing(ball);
  dem::NewParticle one;
  one.scale = ball.radius, one.velocity = before.velocity, one.spin = before.spin;
  one.position.z() = ball.radius - 0.5 * dt * before.velocity.z();
  p.add(std::span(&one, 1));
  Surface plate = test::floor_of(1, 1.9);
  plate.material = 1;
  p.set_surfaces({&plate});
  bool met = false;
  for (int step = 0; step < 1000000; ++step) {
    p.advance(dt, 1);
    const bool touches = p.totals().contacts > 0;
    if (met && !touches) break;
    met |= touches;
  }
  return {p[0].velocity, p[0].spin};
}

// t_c = 2.943 d / v, d = (15 m v^2 / (16 E* sqrt(R)))^0.4, against a rigid plate.
double contact_time(const Ball& b, double v) {
  const double mass = b.density * test::sphere().volume * std::pow(b.radius, 3);
  if (!b.hertz) return std::numbers::pi * std::sqrt(mass / 1e6);
  const double e_star = b.young / (1 - b.poisson * b.poisson);
  return 2.943 * std::pow(15 * mass * v * v / (16 * e_star * std::sqrt(b.radius)), 0.4) / v;
}

TEST(Impact, FrictionWhileSlidingIsMuOfTheNormalImpulse) {
  for (const bool hertz : {true, false})
    for (const double e : {0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0}) {
      if (!hertz && e < 1) continue;
      const Ball ball{.restitution = e, .friction = 0.6, .hertz = hertz};
      const Motion before{{1.932, 0, -0.5176}, Vec3::Zero()};
      const Motion after = thrown(ball, before, 0.01 * contact_time(ball, 0.5176));
      const Vec3 change = after.velocity - before.velocity;
      verified::near(fmt::format("tangential over normal impulse, e = {:g}, {}", e,
                                 hertz ? "hertz" : "linear"),
                     "-", -change.x() / change.z(), 0.6, 1e-9);
    }
}

}  // namespace
}  // namespace trackbed
