// Bonds: a beam with exact deflections, forces that derive from an energy, strengths, and results
// that depend neither on ranks nor on a restart.
#include "dem/bond/bond.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "support/scene.hpp"
#include "support/stone_pairs.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::bond_test {
namespace {

constexpr double pi = std::numbers::pi;

dem::ContactLaw elastic() {
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e6;
  law.friction = 0.5;
  return law;
}

dem::BondParameters strong() {
  dem::BondParameters p;
  p.name = "glue";
  p.young = 1e8, p.tension = p.shear = 1e12;
  return p;
}

Vec3 draw(std::uint64_t key, std::uint64_t k) {
  return Vec3(uniform(k, key), uniform(k + 1, key), uniform(k + 2, key)) - Vec3::Constant(0.5);
}

Quat attitude(std::uint64_t key) {
  return Quat(uniform(1, key) - 0.5, uniform(2, key) - 0.5, uniform(3, key) - 0.5,
              uniform(4, key) - 0.5)
      .normalized();
}

dem::BondedBody body(std::uint64_t key, const Vec3& x) {
  return {x, attitude(key), Vec3::Zero(), Vec3::Zero(), 0.1, 1e-5};
}

// Both stones of a bond, moved a little from where it was made.
struct Pair {
  dem::BondedBody i, j;
  dem::Bond bond;
  dem::BondParameters p = strong();
  dem::Domain domain = test::box(Vec3::Constant(-1), Vec3::Constant(1));

  explicit Pair(std::uint64_t key, double moved)
      : i(body(key, Vec3(0.01, 0, 0))), j(body(key + 100, Vec3(0.03, 0.02, 0.05))) {
    const Vec3 normal = (j.x - i.x).normalized();
    const Vec3 point = i.x + 0.4 * (j.x - i.x) + 0.004 * draw(key, 20);
    bond = dem::make_bond(1, 2, 0, i, j, point, normal, 0.01);
    p.shear_ratio = 0.3;
    j.x += moved * 0.05 * draw(key, 30);
    const Vec3 turn = moved * draw(key, 40);
    j.q = Quat(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * j.q;
  }
  dem::BondResponse respond() const { return dem::respond(bond, p, domain, i, j); }
};

TEST(Bond, IsMadeWithoutForce) {
  for (std::uint64_t key = 0; key < 20; ++key) {
    const dem::BondResponse r = Pair(key, 0).respond();
    EXPECT_LT(r.force.norm(), 1e-8);
    EXPECT_LT(r.moment.norm(), 1e-10);
  }
}

// Rotating and moving both stones together changes no energy and turns the force with them.
TEST(Bond, MovesWithBothStones) {
  for (std::uint64_t key = 0; key < 20; ++key) {
    Pair pair(key, 0.02);
    const dem::BondResponse before = pair.respond();
    const Quat turn = attitude(key + 7);
    const Vec3 shift = draw(key, 3);
    for (dem::BondedBody* body : {&pair.i, &pair.j})
      body->x = turn * body->x + shift, body->q = turn * body->q;
    const dem::BondResponse after = pair.respond();
    EXPECT_NEAR(after.energy, before.energy, 1e-10 * before.energy);
    EXPECT_LT((after.force - turn * before.force).norm(), 1e-9 * before.force.norm());
    EXPECT_LT((after.moment - turn * before.moment).norm(), 1e-9 * before.moment.norm());
  }
}

// Forces and moments on both stones are minus the gradient of the energy, but for a part of second
// order: with a tenth of the displacement it is a hundredth of the force times a tenth.
TEST(Bond, ForceDerivesFromItsEnergy) {
  const auto worst = [](double moved) {
    double error = 0;
    for (std::uint64_t key = 0; key < 20; ++key) {
      const Pair pair(key, moved);
      const dem::BondResponse r = pair.respond();
      const double size = r.force.norm();
      for (int side = 0; side < 2; ++side)
        for (int axis = 0; axis < 6; ++axis) {
          const double step = axis < 3 ? 1e-8 : 1e-7;
          double energy[2];
          for (int k = 0; k < 2; ++k) {
            Pair at = pair;
            dem::BondedBody& body = side == 0 ? at.i : at.j;
            const double h = k == 0 ? -step : step;
            if (axis < 3)
              body.x[axis] += h;
            else
              body.q = Quat(Eigen::AngleAxisd(h, Vec3::Unit(axis - 3))) * body.q;
            energy[k] = at.respond().energy;
          }
          const double sign = side == 0 ? 1 : -1;
          const Vec3 force = sign * r.force;
          const Vec3 centre = side == 0 ? pair.i.x : pair.j.x;
          const Vec3 moment = (r.point - centre).cross(force) + sign * r.moment;
          const double given = axis < 3 ? force[axis] : moment[axis - 3];
          const double length = axis < 3 ? 1 : 0.05;  // m, of the arms
          error = std::max(
              error, std::abs(given + (energy[1] - energy[0]) / (2 * step)) / (size * length));
        }
    }
    return error;
  };
  const double coarse = worst(0.1), fine = worst(0.01);
  EXPECT_LT(coarse, 2e-2);
  EXPECT_LT(fine, 0.15 * coarse);
}

// Stiffness and stress of a beam with a round section, by each of the four motions.
TEST(Bond, HasTheStiffnessOfABeam) {
  Pair pair(3, 0);
  constexpr double small = 1e-5;
  const double r = pair.bond.radius, length = pair.bond.length;
  const double e = pair.p.young, g = pair.p.shear_ratio * e;
  const double area = pi * r * r, inertia = pi / 4 * r * r * r * r;
  const Quat axes = pair.i.q * Quat(Eigen::Map<const Eigen::Vector4d>(pair.bond.axes[0]));
  const Vec3 along = axes * Vec3::UnitX(), across = axes * Vec3::UnitY();
  Pair pulled = pair;
  pulled.j.x += small * along;
  EXPECT_NEAR(pulled.respond().force.dot(along), e * area / length * small, 1e-6 * e * area);
  EXPECT_NEAR(pulled.respond().normal, e * small / length, 1e-6 * e * small / length);
  Pair sheared = pair;
  sheared.j.x += small * across;
  EXPECT_NEAR(sheared.respond().shear, g * small / length, 1e-6 * g * small / length);
  const Vec3 point = pair.respond().point;
  const auto turned = [&](const Vec3& axis) {
    Pair one = pair;
    const Quat turn(Eigen::AngleAxisd(small, axis));
    one.j.x = point + turn * (one.j.x - point), one.j.q = turn * one.j.q;
    return one.respond();
  };
  const dem::BondResponse bent = turned(across), twisted = turned(along);
  EXPECT_NEAR(bent.moment.dot(across), e * inertia / length * small,
              1e-6 * e * inertia / length * small);
  EXPECT_NEAR(bent.normal, e * r / length * small, 1e-6 * e * r / length * small);
  EXPECT_NEAR(twisted.moment.dot(along), 2 * g * inertia / length * small,
              1e-6 * g * inertia / length * small);
  EXPECT_NEAR(twisted.shear, g * r / length * small, 1e-6 * g * r / length * small);
}

// A horizontal row of n bonded balls, the first of which is held, under its own weight.
struct Cantilever {
  static constexpr double length = 0.5, density = 2500;
  static constexpr double weak = 0.01;  // m/s^2: the deflections are small
  int n;
  double ball = length / (2 * n);  // m
  dem::BondParameters p = strong();
  dem::Particles particles;

  explicit Cantilever(int balls, const dem::Domain& domain)
      : n(balls), particles(par::Comm::self(), physics(), {.gravity = weak}, domain) {
    p.young = 1e8;
    particles.set_bonds({p});
    particles.add_template(domain.dimension == Dimension::plane ? test::disk() : test::sphere());
    std::vector<dem::NewParticle> row;
    for (int k = 0; k <= n; ++k) {
      dem::NewParticle one;
      one.id = k, one.scale = ball, one.position = Vec3(2 * ball * k, 0, 0);
      one.held = k == 0;
      row.push_back(one);
    }
    particles.add(row);
    particles.set_surfaces({});
    EXPECT_EQ(particles.bond(0), n);
  }
  static dem::Physics physics() {
    dem::Physics physics = test::one_material(elastic(), density);
    physics.materials[0].local_damping = 0.7;
    return physics;
  }
  double tip() const { return -particles[static_cast<std::size_t>(n)].position.z(); }
  // At rest, m.
  double deflection() {
    const double dt = particles.stable_step();
    double last = 1, now = 0;
    for (int w = 0; w < 100000 && std::abs(now - last) > 1e-9 * std::abs(now); ++w) {
      particles.advance(200 * dt, 200);
      last = now, now = tip();
    }
    return now;
  }
};

// The sum over the bonds of their bending and shear by the weights beyond them, and Timoshenko's
// beam with half a ball more at its end.
TEST(Bond, CantileverBendsLikeABeam) {
  const dem::Domain space = test::box(Vec3::Constant(-0.7), Vec3::Constant(0.7));
  dem::Domain plane = space;
  plane.dimension = Dimension::plane, plane.thickness = 0.3;
  for (const dem::Domain& domain : {space, plane}) {
    std::vector<double> errors;
    for (const int n : {4, 8, 16}) {
      Cantilever beam(n, domain);
      const double r = beam.p.radius * beam.ball, l = 2 * beam.ball;
      const bool flat = domain.dimension == Dimension::plane;
      const double area = flat ? 2 * r * domain.thickness : pi * r * r;
      const double inertia = flat ? 2.0 / 3 * r * r * r * domain.thickness : pi / 4 * r * r * r * r;
      const double ei = beam.p.young * inertia, ga = beam.p.shear_ratio * beam.p.young * area;
      const double weight = Cantilever::weak * Cantilever::density *
                            (flat ? pi * beam.ball * beam.ball * domain.thickness
                                  : 4 * pi / 3 * beam.ball * beam.ball * beam.ball);
      double exact = 0;
      for (int k = 0; k < n; ++k) {
        double moment = 0;
        for (int j = k + 1; j <= n; ++j) moment += weight * l * (j - k - 0.5);
        exact += moment * l / ei * l * (n - k - 0.5) + weight * (n - k) * l / ga;
      }
      const double found = beam.deflection();
      EXPECT_NEAR(found, exact, 2e-4 * exact) << n;
      const double q = weight / l, L = Cantilever::length;
      const double beam_of_timoshenko = q * L * L * L * L / (8 * ei) + q * L * L / (2 * ga) +
                                        weight / 2 * (L * L * L / (3 * ei) + L / ga);
      errors.push_back(std::abs(found / beam_of_timoshenko - 1));
    }
    for (std::size_t k = 1; k < errors.size(); ++k)
      EXPECT_GT(std::log2(errors[k - 1] / errors[k]), 1.7) << "order of convergence";
  }
}

// Two bonded balls of different size that spin and swing: energy, momentum and angular momentum.
TEST(Bond, KeepsEnergyAndMomentum) {
  dem::ContactLaw smooth = elastic();
  smooth.friction = 0;
  dem::Particles particles(par::Comm::self(), test::one_material(smooth), {.gravity = 0},
                           test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  particles.set_bonds({strong()});
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> two(2);
  two[0].id = 0, two[0].scale = 0.02, two[0].position = Vec3(-0.02, 0, 0);
  two[1].id = 1, two[1].scale = 0.03, two[1].position = Vec3(0.03, 0, 0);
  two[0].velocity = Vec3(0.1, -1, 0.4), two[1].velocity = Vec3(-0.3, 0.5, 0.2);
  two[0].spin = Vec3(20, -30, 10);
  particles.add(two);
  particles.set_surfaces({});
  ASSERT_EQ(particles.bond(0), 1);
  const auto spin = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t b = 0; b < 2; ++b)
      sum += particles[b].angular_momentum +
             particles[b].mass * particles[b].position.cross(particles[b].velocity);
    return sum;
  };
  const dem::Totals before = particles.totals();
  const Vec3 turning = spin();
  const double dt = 0.25 * particles.stable_step();
  double swing = 0, error = 0;
  for (int w = 0; w < 400; ++w) {
    particles.advance(50 * dt, 50);
    ASSERT_EQ(particles.trouble(), "");
    const dem::Totals now = particles.totals();
    swing = std::max(swing, now.elastic);
    error = std::max(error, std::abs(now.kinetic + now.elastic - before.kinetic));
    EXPECT_LT((now.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
    EXPECT_LT((spin() - turning).norm(), 1e-11 * turning.norm());
  }
  // The integrator's error is (w dt)^2/8 of the energy that swings, w dt = 0.1 here, and does not
  // grow; that of the moments is of the third order in the rotation.
  EXPECT_LT(error, 5e-3 * swing);
  EXPECT_GT(swing, 0.01 * before.kinetic);
}

// Two equal balls that swing or twist against each other: the amplitude falls by the factor
// exp(-2 pi z/sqrt(1 - z^2)) in a period, and the motion of both together stays.
TEST(Bond, DampsRelativeMotion) {
  dem::ContactLaw none = elastic();
  none.k_n = none.k_s = 1e-3;
  for (const auto& [ratio, twists] :
       {std::pair{0.1, false}, {0.3, false}, {0.1, true}, {0.3, true}}) {
    dem::Particles particles(par::Comm::self(), test::one_material(none), {.gravity = 0},
                             test::box(Vec3::Constant(-1), Vec3::Constant(1)));
    dem::BondParameters p = strong();
    p.damping = ratio;
    particles.set_bonds({p});
    particles.add_template(test::sphere());
    constexpr double ball = 0.02;
    std::vector<dem::NewParticle> two(2);
    two[0].id = 0, two[0].scale = ball, two[0].position = Vec3(-ball, 0, 0);
    two[1].id = 1, two[1].scale = ball, two[1].position = Vec3(ball, 0, 0);
    two[0].velocity = two[1].velocity = Vec3(1, 0, 0);
    (twists ? two[0].spin : two[0].velocity).x() += 0.1;
    (twists ? two[1].spin : two[1].velocity).x() -= 0.1;
    particles.add(two);
    particles.set_surfaces({});
    ASSERT_EQ(particles.bond(0), 1);
    const double r = p.radius * ball, mass = particles[0].mass, length = 2 * ball;
    const double stretch = p.young * pi * r * r / length / (mass / 2);
    const double twist =
        p.shear_ratio * p.young * pi / 2 * r * r * r * r / length / (0.2 * mass * ball * ball);
    const double w = std::sqrt(twists ? twist : stretch);
    const double period = 2 * pi / (w * std::sqrt(1 - ratio * ratio));
    particles.advance(period, 20000);
    const dem::ParticleView one = particles[0], other = particles[1];
    const double left =
        twists ? one.spin.x() - other.spin.x() : one.velocity.x() - other.velocity.x();
    const double expected = 0.2 * std::exp(-2 * pi * ratio / std::sqrt(1 - ratio * ratio));
    EXPECT_NEAR(left, expected, 2e-3 * expected) << ratio << (twists ? ", twisted" : "");
    EXPECT_NEAR(one.velocity.x() + other.velocity.x(), 2, 1e-12);
  }
}

// A block of balls with up to 26 bonds each, at the limit of stability and with strong dampers.
TEST(Bond, StableStepIsStable) {
  dem::ContactLaw none = elastic();
  none.k_n = none.k_s = 1e-3;
  for (const double ratio : {0.0, 0.3, 1.0}) {
    dem::Particles particles(par::Comm::self(), test::one_material(none),
                             {.safety = 1, .gravity = 0},
                             test::box(Vec3::Constant(-1), Vec3::Constant(1)));
    dem::BondParameters p = strong();
    p.damping = ratio, p.gap = 0.016;
    particles.set_bonds({p});
    particles.add_template(test::sphere());
    auto block = test::lattice({4, 4, 4}, 0.0201, 0.01, 1);
    for (dem::NewParticle& ball : block) {
      ball.scale = 0.01, ball.velocity *= 0.1;
      ball.spin = Vec3(3, -2, 1) * static_cast<double>(ball.id % 3);
    }
    particles.add(block);
    particles.set_surfaces({});
    ASSERT_GT(particles.bond(0), 400);
    const double before = particles.totals().kinetic, dt = particles.stable_step();
    for (int w = 0; w < 200; ++w) particles.advance(50 * dt, 50);
    ASSERT_EQ(particles.trouble(), "");
    const dem::Totals after = particles.totals();
    EXPECT_LT(after.kinetic + after.elastic, (ratio > 0 ? 0.9 : 1.5) * before) << ratio;
    EXPECT_EQ(particles.bonded().whole, particles.bonded().made);
  }
}

// However strong, a bond breaks at a length that depends on neither skin nor lists.
TEST(Bond, BreaksAtItsReach) {
  for (const double skin : {3e-3, 8e-3}) {
    dem::Particles particles(par::Comm::self(), test::one_material(elastic()),
                             {.skin = skin, .gravity = 0},
                             test::box(Vec3::Constant(-1), Vec3::Constant(1)));
    dem::BondParameters p = strong();
    p.gap = 1e-3, p.young = 1e3;
    particles.set_bonds({p});
    particles.add_template(test::sphere());
    constexpr double ball = 0.01, gap = 0.9e-3, speed = 1;
    std::vector<dem::NewParticle> two(2);
    two[0].id = 0, two[0].scale = ball, two[0].held = true;
    two[1].id = 1, two[1].scale = ball, two[1].position = Vec3(2 * ball + gap, 0, 0);
    two[1].velocity = Vec3(speed, 0, 0);
    particles.add(two);
    particles.set_surfaces({});
    ASSERT_EQ(particles.bond(0), 1);
    constexpr double dt = 1e-5;
    for (int w = 0; w < 1000 && particles.bonded().whole == 1; ++w) particles.advance(dt, 1);
    ASSERT_EQ(particles.trouble(), "");
    EXPECT_NEAR(particles[1].position.x(), 2 * ball + p.gap + 0.1 * ball, 2 * speed * dt) << skin;
  }
}

// The free ball in the middle of three, of which the outer ones are slowly pulled apart.
TEST(Bond, BreaksAtItsTensileStrength) {
  dem::BondParameters p = strong();
  p.young = 1e7, p.tension = 1e4, p.shear = 1e9;
  dem::Particles particles(par::Comm::self(), test::one_material(elastic()), {.gravity = 0},
                           test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  particles.set_bonds({p});
  particles.add_template(test::sphere());
  constexpr double ball = 0.02, speed = 0.004;
  std::vector<dem::NewParticle> row(3);
  for (std::size_t k = 0; k < 3; ++k) {
    row[k].id = static_cast<Id>(k), row[k].scale = ball;
    row[k].position = Vec3(2 * ball * static_cast<double>(k), 0, 0);
    row[k].velocity = Vec3(speed * static_cast<double>(k) / 2, 0, 0);
    row[k].held = k != 1;
  }
  particles.add(row);
  particles.set_surfaces({});
  ASSERT_EQ(particles.bond(0), 2);
  const double r = p.radius * ball, length = 2 * ball, area = pi * r * r;
  const double stretch = p.tension / p.young * length;  // m, of each bond at its strength
  const double dt = particles.stable_step();
  double largest = 0;
  int steps = 0;
  for (; steps < 2000000 && particles.bond_breaks().empty(); ++steps) {
    particles.advance(dt, 1);
    ASSERT_EQ(particles.trouble(), "");
    largest = std::max(largest, -particles[2].force.x());
  }
  EXPECT_NEAR(largest, p.tension * area, 0.01 * p.tension * area);
  EXPECT_NEAR(steps * dt * speed, 2 * stretch, 0.02 * stretch);
  const dem::BondTotals totals = particles.bonded();
  EXPECT_EQ(totals.made, 2);
  EXPECT_EQ(totals.by_shear, 0);
  EXPECT_EQ(totals.whole + totals.by_tension, 2);
  const dem::BondBreak& first = particles.bond_breaks()[0];
  EXPECT_NEAR(first.time, steps * dt, 1e-9);
  EXPECT_NEAR(first.normal, p.tension, 0.01 * p.tension);
  EXPECT_NEAR(first.energy, 0.5 * p.tension * area * stretch, 0.01 * p.tension * area * stretch);
}

// Pulled slowly until it breaks, a bond takes half of strength, area and final deformation; on the
// way back from a damaged state it follows a straight line to zero.
TEST(Bond, SoftensLinearly) {
  Pair pair(5, 0);
  pair.p.tension = 1e5, pair.p.shear = 1e9, pair.p.softening = 5;
  const Quat axes = pair.i.q * Quat(Eigen::Map<const Eigen::Vector4d>(pair.bond.axes[0]));
  const Vec3 along = axes * Vec3::UnitX(), from = pair.j.x;
  const double peak = pair.p.tension / pair.p.young * pair.bond.length;
  const double force = pair.p.tension * pi * pair.bond.radius * pair.bond.radius;
  constexpr int steps = 10000;
  const double step = pair.p.softening * peak / steps;
  double work = 0, stretch = 0;
  for (; dem::damage(pair.bond.worst, pair.p) < 1; stretch += step) {
    pair.j.x = from + stretch * along;
    const dem::BondResponse r = pair.respond();
    pair.bond.worst = std::max(pair.bond.worst, dem::utilisation(r, pair.p));
    const double pull = pair.respond().force.dot(along);
    work += pull * step;
    const double line =
        std::min(stretch / peak, (pair.p.softening - stretch / peak) / (pair.p.softening - 1));
    ASSERT_NEAR(pull, force * std::max(line, 0.0), 1e-3 * force) << stretch / peak;
    if (stretch < 2 * peak) continue;
    const double damaged = pull / stretch;
    pair.j.x = from + 0.5 * stretch * along;
    ASSERT_NEAR(pair.respond().force.dot(along), 0.5 * damaged * stretch, 1e-6 * force);
  }
  EXPECT_NEAR(stretch, pair.p.softening * peak, 2 * step);
  EXPECT_NEAR(work, 0.5 * force * pair.p.softening * peak, 1e-3 * force * peak);
}

TEST(Bond, KnowsWhatBreaksIt) {
  Pair pair(8, 0);
  pair.p.tension = 1e4, pair.p.shear = 2e4;
  const Quat axes = pair.i.q * Quat(Eigen::Map<const Eigen::Vector4d>(pair.bond.axes[0]));
  const Vec3 point = pair.respond().point;
  const double e = pair.p.young, g = pair.p.shear_ratio * e;
  const double r = pair.bond.radius, length = pair.bond.length;
  // Rotation of one stone about the place of the bond, rad, at which its strength is reached.
  for (const bool twist : {false, true}) {
    const double angle =
        twist ? pair.p.shear * length / (g * r) : pair.p.tension * length / (e * r);
    for (const double part : {0.5, 1.0}) {
      pair.p.moment = part;
      Pair turned = pair;
      const Quat turn(Eigen::AngleAxisd(angle, axes * (twist ? Vec3::UnitX() : Vec3::UnitZ())));
      turned.j.x = point + turn * (pair.j.x - point), turned.j.q = turn * pair.j.q;
      const dem::BondResponse now = turned.respond();
      EXPECT_NEAR(dem::utilisation(now, pair.p), part, 1e-3 * part);
      EXPECT_EQ(dem::by_shear(now, pair.p), twist);
    }
  }
  Pair pressed = pair;
  pressed.j.x -= 1e-3 * (axes * Vec3::UnitX());
  EXPECT_LT(pressed.respond().normal, 0);
  EXPECT_LE(dem::utilisation(pressed.respond(), pair.p), 0 + 1e-9);
}

// Only pairs in the box, of the material, near enough, and each once.
TEST(Bond, IsMadeWhereAsked) {
  dem::Physics physics = test::one_material(elastic());
  physics.materials.push_back(physics.materials[0]);
  physics.materials[1].name = "steel";
  for (const auto& [first, second] : {std::pair{"stone", "steel"}, std::pair{"steel", "steel"}}) {
    dem::ContactLaw law = elastic();
    law.first = first, law.second = second;
    physics.laws.push_back(law);
  }
  constexpr double ball = 0.02;
  dem::Domain ring = test::box({0, -0.1, -0.1}, {10 * 2 * ball, 0.1, 0.1});
  ring.periodic = {true, false, false};
  const auto made = [&](const dem::BondParameters& p, double spacing = 1) {
    dem::Particles particles(par::Comm::self(), physics, {.gravity = 0}, ring);
    particles.set_bonds({p, p});
    particles.add_template(test::sphere());
    std::vector<dem::NewParticle> row(10);
    for (std::size_t k = 0; k < 10; ++k) {
      row[k].id = static_cast<Id>(k), row[k].scale = spacing * ball;
      row[k].position = Vec3(2 * ball * (static_cast<double>(k) + 0.5), 0, 0);
      row[k].material = k < 3 ? 1 : 0;
    }
    particles.add(row);
    particles.set_surfaces({});
    const std::int64_t count = particles.bond(0);
    EXPECT_EQ(particles.bond(1), 0);  // none has a second bond
    EXPECT_EQ(particles.bonded().whole, count);
    particles.advance(1e-6, 1);
    EXPECT_EQ(particles.trouble(), "");
    EXPECT_LT(particles.totals().elastic, 1e-12);
    return count;
  };
  dem::BondParameters p = strong();
  p.gap = 1e-6;
  EXPECT_EQ(made(p), 10);  // with that across the periodic side
  p.material = "stone";
  EXPECT_EQ(made(p), 6);
  p.material.clear();
  p.low = {0.1, -1, -1}, p.high = {0.25, 1, 1};
  EXPECT_EQ(made(p), 4);  // at 0.12, 0.16, 0.20 and 0.24 m
  p.low.clear(), p.high.clear();
  EXPECT_EQ(made(p, 0.95), 0);
  p.gap = 2.1e-3;
  EXPECT_EQ(made(p, 0.95), 10);
  p.gap = 0.01;  // wider than the skin would be, less than two diameters
  EXPECT_EQ(made(p, 0.95), 10);
}

// Face to face, cubes are bonded at the centre of their faces; a bond that pulls the upper one down
// pulls the lower one up.
TEST(Bond, JoinsPolyhedra) {
  dem::Particles particles(par::Comm::self(), test::one_material(elastic()), {.gravity = 0},
                           test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  dem::BondParameters p = strong();
  particles.set_bonds({p});
  dem::Template cube;  // with the axes of its edges
  cube.pieces = {{test::cuboid_core(Vec3::Constant(0.018)), 0.002}};
  cube.volume = 6.3e-5, cube.gyration = Vec3::Constant(2.6e-4);
  particles.add_template(cube);
  std::vector<dem::NewParticle> two(2);
  for (std::size_t k = 0; k < 2; ++k) {
    two[k].id = static_cast<Id>(k);
    two[k].position = Vec3(0, 0, 0.04 * static_cast<double>(k) * (1 - 1e-6));
  }
  two[0].velocity.z() = -0.1, two[1].velocity.z() = 0.1;
  particles.add(two);
  particles.set_surfaces({});
  ASSERT_EQ(particles.bond(0), 1);
  constexpr double dt = 1e-7, moved = 10 * dt * 0.2;  // m, between both
  for (int k = 0; k < 10; ++k) particles.advance(dt, 1);
  int count = 0;
  particles.bonds([&](const dem::BondView& bond) {
    EXPECT_LT((bond.point - Vec3(0, 0, 0.02)).norm(), 1e-5);
    const double r = p.radius * std::cbrt(3 * cube.volume / (4 * pi));
    const double force = p.young * pi * r * r / 0.04 * moved;
    EXPECT_NEAR(bond.force.z(), force, 0.01 * force);  // on the lower one
    EXPECT_LT(bond.force.head<2>().norm(), 1e-6 * force);
    ++count;
  });
  EXPECT_EQ(count, 1);
  EXPECT_GT(particles[0].force.z(), 0);
  EXPECT_LT(particles[1].force.z(), 0);
}

// Blocks of bonded balls and clumps that fall on a floor in a periodic box and break.
struct Blocks {
  Surface floor = test::floor_of(5, 0.7);
  dem::Particles particles;
  bool clumps;
  explicit Blocks(const par::Comm& comm, bool with_clumps, double skin = 0)
      : particles(comm, test::one_material(elastic(), 2500), {.skin = skin, .largest_overlap = 1},
                  domain()),
        clumps(with_clumps) {
    dem::BondParameters p = strong();
    p.young = 2e7, p.tension = 1.5e5, p.shear = 1.5e5, p.softening = 1.5, p.damping = 0.1;
    p.gap = 1e-3;
    particles.set_bonds({p});
  }
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.40, 0.30, 0.6});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm) {
    particles.add_template(test::sphere());
    if (clumps) particles.add_template(test::clump());
    std::vector<dem::NewParticle> all;
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 5; ++j)
        for (int k = 0; k < 4; ++k) {
          dem::NewParticle p;
          p.id = static_cast<Id>(all.size());
          p.scale = 0.02, p.shape = clumps && (i + j + k) % 4 == 0 ? 1 : 0;
          p.position = Vec3(0.02 + 0.04 * i + (i > 3 ? 0.06 : 0), 0.05 + 0.04 * j, 0.03 + 0.04 * k);
          p.velocity = Vec3(i > 3 ? -1.5 : 1.5, 0.3, -2);
          all.push_back(p);
        }
    particles.add(test::mine(comm, all));
    connect();
    made = particles.bond(0);
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int windows, int moves = 0) {
    for (int w = 0; w < windows; ++w) {
      if (moves > 0 && w % moves == moves - 1) particles.repartition();
      particles.advance(4e-5, 4);
      EXPECT_EQ(particles.trouble(), "");
    }
  }
  std::int64_t made = 0;
};

TEST(BondRanks, DoNotDependOnListsAndRanks) {
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  for (const bool clumps : {false, true}) {
    Blocks shared(world, clumps, 4e-3), alone(self, clumps);
    shared.pour(world), alone.pour(self);
    EXPECT_EQ(shared.made, alone.made);
    EXPECT_GT(alone.made, 100);
    EXPECT_LE(shared.particles.stable_step(), 1e-4);
    EXPECT_EQ(shared.particles.stable_step(), alone.particles.stable_step());
    shared.run(400, 50), alone.run(400);
    EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
    const dem::BondTotals one = alone.particles.bonded(), all = shared.particles.bonded();
    EXPECT_GT(one.by_tension, 5);
    EXPECT_GT(one.by_shear, 5);
    EXPECT_GT(one.whole, 10);
    EXPECT_EQ(one.made, one.whole + one.by_tension + one.by_shear);
    EXPECT_EQ(one.by_tension, all.by_tension);
    EXPECT_EQ(one.by_shear, all.by_shear);
    EXPECT_EQ(one.whole, all.whole);
    EXPECT_EQ(one.released, all.released);
    EXPECT_EQ(alone.particles.totals().elastic, shared.particles.totals().elastic);
  }
}

// A row of balls that is drawn apart across all ranks, with weak springs of any strength: bonds
// break at their length, also after small balls have come, for which the skin would be shorter.
TEST(BondRanks, BreakAtTheirLengthOnAnyRanks) {
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  constexpr int n = 16;
  constexpr double ball = 0.01, gap = 2e-3;
  const auto drawn = [&](const par::Comm& comm) {
    dem::Particles particles(comm, test::one_material(elastic()), {.gravity = 0},
                             test::box(Vec3(-0.1, -0.1, -0.1), Vec3(0.8, 0.1, 0.1)));
    dem::BondParameters p = strong();
    p.gap = gap, p.young = 1e3;
    particles.set_bonds({p});
    particles.add_template(test::sphere());
    std::vector<dem::NewParticle> row(n), small(1);
    for (int k = 0; k < n; ++k) {
      dem::NewParticle& one = row[static_cast<std::size_t>(k)];
      one.id = k, one.scale = ball, one.position = Vec3((2 * ball + 0.9 * gap) * k, 0, 0);
      one.velocity = Vec3(0.5 * k + 0.01 * (k % 3), 0.01 * (k % 2), 0);
    }
    particles.add(test::mine(comm, row));
    particles.set_surfaces({});
    EXPECT_EQ(particles.bond(0), n - 1);
    small[0].id = n, small[0].scale = 0.1 * ball, small[0].position = Vec3(0.3, 0.05, 0.05);
    particles.add(test::mine(comm, small));
    for (int w = 0; w < 200; ++w) {
      particles.advance(4e-5, 4);
      EXPECT_EQ(particles.trouble(), "");
    }
    const dem::BondTotals totals = particles.bonded();
    return std::tuple(particles.state_hash(), totals.by_tension, totals.whole);
  };
  const auto alone = drawn(self);
  EXPECT_EQ(drawn(world), alone);
  EXPECT_EQ(std::get<1>(alone), n - 1);
}

TEST(BondRanks, ContinueFromACheckpoint) {
  const par::Comm world = par::Comm::world();
  for (const bool clumps : {false, true}) {
    const std::string path = "bond_" + std::to_string(world.size()) + ".h5";
    Blocks whole(world, clumps), second(world, clumps);
    whole.pour(world);
    while (whole.particles.bonded().by_tension + whole.particles.bonded().by_shear < 8)
      whole.run(1);
    {
      io::File file(world, path, io::Mode::create);
      whole.particles.save(file, "p");
    }
    {
      const io::File file(world, path, io::Mode::read);
      second.particles.load(file, "p");
    }
    second.connect();
    second.run(150), whole.run(150);
    EXPECT_EQ(second.particles.state_hash(), whole.particles.state_hash());
    const dem::BondTotals one = whole.particles.bonded(), other = second.particles.bonded();
    EXPECT_EQ(one.whole, other.whole);
    EXPECT_EQ(one.by_tension, other.by_tension);
    EXPECT_EQ(one.released, other.released);
    EXPECT_GT(one.by_tension + one.by_shear, 12);
    world.barrier();
    if (world.root()) std::filesystem::remove(path);
  }
}

TEST(Bond, GoWithRemovedStones) {
  Blocks blocks(par::Comm::self(), false);
  blocks.pour(par::Comm::self());
  std::int64_t gone = 0;
  blocks.particles.bonds([&](const dem::BondView& bond) {
    if (bond.first == 17 || bond.second == 17) ++gone;
  });
  EXPECT_GT(gone, 2);
  blocks.particles.remove([](const dem::ParticleView& stone) { return stone.id == 17; });
  EXPECT_EQ(blocks.particles.bonded().whole, blocks.made - gone);
  blocks.run(3);
}

}  // namespace
}  // namespace trackbed::bond_test
