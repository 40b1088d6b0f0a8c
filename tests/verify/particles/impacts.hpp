// Impact of a ball on a plate, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "support/scene.hpp"

namespace trackbed::impacts {

struct Ball {
  double young = 1e9, poisson = 0.27, density = 2500, radius = 0.02;
  double restitution = 1, friction = 0;
  bool hertz = true;
  double zeta = 0;                               // linear only
  double plate_young = 1e30, plate_poisson = 0;  // rigid
  double k_n = 1e6, k_s = 8e5;                   // linear only
  double place = 0.5;  // initial gap to the plate, over the distance per step
  double mass() const { return density * test::sphere().volume * std::pow(radius, 3); }
  double e_star() const {
    return 1 /
           ((1 - poisson * poisson) / young + (1 - plate_poisson * plate_poisson) / plate_young);
  }
  double g_star() const {
    const auto soft = [](double nu, double e) { return 2 * (2 - nu) * (1 + nu) / e; };
    return 1 / (soft(poisson, young) + soft(plate_poisson, plate_young));
  }
};

// One material for balls, and a second for the plate.
inline dem::Physics physics_of(const Ball& b) {
  dem::Physics physics;
  physics.materials = {
      {.name = "ball", .density = b.density, .young = b.young, .poisson = b.poisson},
      {.name = "plate", .young = b.plate_young, .poisson = b.plate_poisson}};
  for (const char* second : {"ball", "plate"}) {
    dem::ContactLaw law{.first = "ball", .second = second};
    law.kind = b.hertz ? dem::LawKind::hertz : dem::LawKind::linear;
    law.restitution = b.restitution, law.friction = b.friction;
    law.k_n = b.k_n, law.k_s = b.k_s;
    law.zeta_n = law.zeta_s = b.zeta;
    physics.laws.push_back(law);
  }
  return physics;
}

inline dem::Particles nothing(const Ball& ball) {
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10;
  dem::Particles p(par::Comm::self(), physics_of(ball), parameters,
                   test::box(Vec3::Constant(-50 * ball.radius), Vec3::Constant(50 * ball.radius)));
  p.add_template(test::sphere());
  return p;
}

struct Motion {
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
};

using Observer = std::function<void(const dem::ParticleView&)>;

// Simulates the impact until the ball separates from the plate z = 0; `observe` is called with the
// ball after each step in contact.
inline Motion impact(const Ball& ball, const Motion& before, double dt,
                     const Observer& observe = {}) {
  dem::Particles p = nothing(ball);
  dem::NewParticle one;
  one.scale = ball.radius, one.velocity = before.velocity, one.spin = before.spin;
  one.position.z() = ball.radius - ball.place * dt * before.velocity.z();
  p.add(std::span(&one, 1));
  Surface plate = test::floor_of(1, 20 * ball.radius);
  plate.material = 1;
  p.set_surfaces({&plate});
  bool collided = false;
  for (int step = 0; step < 1000000; ++step) {
    p.advance(dt, 1);
    const bool touches = p.totals().contacts > 0;
    if (collided && !touches) break;
    collided |= touches;
    if (touches && observe) observe(p[0]);
  }
  return {p[0].velocity, p[0].spin};
}

// m, largest overlap of a Hertz impact at v m/s: d = (15 m v^2 / (16 E* sqrt(R)))^0.4.
inline double depth(const Ball& b, double v) {
  return std::pow(15 * b.mass() * v * v / (16 * b.e_star() * std::sqrt(b.radius)), 0.4);
}

// t_c = 2.943 d / v.
inline double contact_time(const Ball& b, double v) {
  if (!b.hertz) return std::numbers::pi * std::sqrt(b.mass() / b.k_n);
  return 2.943 * depth(b, v) / v;
}

// An elastic Hertz impact with any tangential force: `friction(overlap, slip)` is that against the
// slip, moved by `slip` (m); step: `fraction` of the collision time.
template <class Friction>
Motion integrated(const Ball& b, const Motion& before, double fraction, Friction&& friction) {
  const double mass = b.mass(), dt = fraction * contact_time(b, -before.velocity.z());
  Motion now = before;
  for (double delta = -now.velocity.z() * dt; delta > 0; delta -= now.velocity.z() * dt) {
    const double arm = b.radius - delta;
    const double normal = 4.0 / 3.0 * b.e_star() * std::sqrt(b.radius * delta) * delta;
    const double along = -friction(delta, (now.velocity.x() - now.spin.y() * arm) * dt);
    now.velocity += Vec3(along, 0, normal) * dt / mass;
    now.spin.y() -= arm * along * dt / (0.4 * mass * b.radius * b.radius);
  }
  return now;
}

// The same with the increments of Mindlin's force, dF = k du while the contact grows and dF = k du
// + F dk / k while it shrinks, limited to mu F_n.
inline Motion by_increments(const Ball& b, const Motion& before) {
  double force = 0, k = 0;
  return integrated(b, before, 1e-5, [&](double delta, double slip) {
    const double a = std::sqrt(b.radius * delta), stiffness = 8 * b.g_star() * a;
    const double limit = b.friction * 4.0 / 3.0 * b.e_star() * a * delta;
    if (stiffness < k) force *= stiffness / k;
    k = stiffness;
    return force = std::clamp(force + k * slip, -limit, limit);
  });
}

}  // namespace trackbed::impacts
