// A ball between two plates, without gravity and damping: it bounces for ever, and friction and the
// tangential spring must not give it energy. TRACKBED_BOUNCES asks for more than the usual bounces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/scene.hpp"
#include "support/verified.hpp"

namespace trackbed {
namespace {

constexpr double radius = 0.01, density = 2500, young = 70e9, k_n = 1e6, speed = 0.2;

dem::Physics physics_of(bool hertz, double poisson, double friction) {
  dem::Physics physics;
  physics.materials = {{.name = "ball", .density = density, .young = young, .poisson = poisson}};
  dem::ContactLaw law{.first = "ball", .second = "ball"};
  law.kind = hertz ? dem::LawKind::hertz : dem::LawKind::linear;
  law.k_n = k_n, law.k_s = 0.8 * k_n, law.friction = friction;
  physics.laws = {law};
  return physics;
}

double kinetic(const dem::ParticleView& p) {
  return 0.5 * p.mass * (p.velocity.squaredNorm() + 0.4 * radius * radius * p.spin.squaredNorm());
}

// Largest rise of the energy above any earlier value, over its first.
double largest_rise(const dem::Physics& physics, double contact_time, int bounces) {
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(par::Comm::self(), physics, parameters,
                   test::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = radius, one.velocity = Vec3(0, 0, -speed), one.spin = Vec3(0, -3, 0);
  const double gap = speed * contact_time;
  one.position.z() = radius + 0.5 * gap;
  p.add(std::span(&one, 1));
  Surface low = test::floor_of(1, 0.1), high = test::floor_of(1, 0.1, 2 * radius + gap, "top");
  for (auto& t : high.triangles) std::swap(t[1], t[2]);
  p.set_surfaces({&low, &high});
  const double first = kinetic(p[0]);
  double least = first, rise = 0;
  bool touched = false;
  for (int done = 0; done < bounces;) {
    p.advance(0.02 * contact_time, 1);
    const double z = p[0].position.z();
    const bool touches = z < radius || z > radius + gap;
    if (touched && !touches) {
      // The last step of the contact still moved the ball: its velocity is whole a step later.
      p.advance(0.02 * contact_time, 1);
      const double now = kinetic(p[0]);
      rise = std::max(rise, now - least), least = std::min(least, now);
      ++done;
    }
    touched = touches;
  }
  return rise / first;
}

TEST(Bounces, NeverRaiseTheEnergy) {
  const char* asked = std::getenv("TRACKBED_BOUNCES");
  const int bounces = asked ? std::atoi(asked) : 200;
  const double mass = density * test::sphere().volume * std::pow(radius, 3);
  for (const bool hertz : {true, false})
    for (const double poisson : {0.1, 0.25, 0.4})
      for (const double friction : {0.0, 0.3, 0.7, 5.0}) {
        if (!hertz && poisson > 0.1) continue;  // is of no account
        const double e_star = young / (2 * (1 - poisson * poisson));
        const double depth =
            std::pow(15 * mass * speed * speed / (16 * e_star * std::sqrt(radius)), 0.4);
        const double time = hertz ? 2.943 * depth / speed : M_PI * std::sqrt(mass / k_n);
        const double rise = largest_rise(physics_of(hertz, poisson, friction), time, bounces);
        verified::below(
            fmt::format("rise of energy in {} bounces, {}, friction {:g}", bounces,
                        hertz ? fmt::format("hertz, nu {:g}", poisson) : "linear", friction),
            "of the first", rise, 1e-6);
      }
}

}  // namespace
}  // namespace trackbed
