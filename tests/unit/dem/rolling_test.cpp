// Rolling resistance: a sphere on a plane compared with hand calculation, balance of moments and
// energy, and no disturbance of blocks.
#include <gtest/gtest.h>

#include "dem/particles/couple.hpp"
#include "support/stone_pairs.hpp"
#include "support/stones.hpp"

namespace trackbed::rolling_test {
namespace {

constexpr double dt = 2e-5;    // s, sqrt(m/k) is 6e-4 s
constexpr double mu_r = 0.05;  // -

dem::ContactLaw rolling(double mu = mu_r) {
  dem::ContactLaw law;
  law.k_n = 2e5, law.k_s = 1.5e5;
  law.friction = 0.5;
  law.zeta_n = law.zeta_s = 0.3;
  law.rolling_friction = mu, law.rolling_stiffness = 0.5, law.zeta_r = 0.3;
  return law;
}

// One particle of unit scale on a floor that falls by `slope` along x.
struct Slope {
  Surface floor = test::floor_of(5, 2.5);
  dem::Particles p;

  Slope(const dem::ContactLaw& law, const dem::Template& shape, const dem::NewParticle& one,
        double slope = 0)
      : p(par::Comm::self(), test::one_material(law), {.largest_overlap = 1},
          test::box(Vec3::Constant(-3), Vec3::Constant(3))) {
    p.add_template(shape);
    p.add(std::span(&one, 1));
    for (Vec3& x : floor.position) x.z() = -slope * x.x();
    p.set_surfaces({&floor});
  }
  double x_after(double seconds) {
    for (int k = 0; k < static_cast<int>(std::lround(seconds / (500 * dt))); ++k)
      p.advance(500 * dt, 500);
    EXPECT_EQ(p.trouble(), "");
    return p[0].position.x();
  }
};

constexpr double r = 0.02;  // m

// A sphere in contact with the slope without overlap.
dem::NewParticle at_rest(double slope) {
  dem::NewParticle one;
  one.position = r * Vec3(slope, 0, 1) / std::hypot(1, slope) + Vec3(0.01, 0.007, -0.01 * slope);
  return one;
}

dem::NewParticle rolling_at(double v) {
  dem::NewParticle one = at_rest(0);
  one.velocity.x() = v, one.spin.y() = v / r;
  return one;
}

// For linear and for Hertz springs.
class RollingLaw : public testing::TestWithParam<bool> {
 protected:
  dem::Physics physics(dem::ContactLaw law) const {
    law.kind = GetParam() ? dem::LawKind::hertz : dem::LawKind::linear;
    dem::Physics all = test::one_material(law);
    all.materials[0].young = 5e7;
    return all;
  }
};

TEST(Rolling, ASphereStopsWhereTheMomentHasUsedItsEnergy) {
  // (m + I / r^2) dv/dt = -mu_r m g, I = 2/5 m r^2: the distance is 7/5 v^2 / (2 mu_r g).
  const double v = 0.3, distance = 1.4 * v * v / (2 * mu_r * gravity);
  Slope scene(rolling(), test::sphere(r), rolling_at(v));
  const double start = scene.p[0].position.x(), x = scene.x_after(1.5);
  constexpr double margin = 2e-3;  // of the distance: first contact, stretch of the springs
  EXPECT_NEAR(x - start, distance, margin * distance);
  EXPECT_LT(scene.p[0].velocity.norm(), 1e-9);
  EXPECT_EQ(scene.x_after(0.5), x) << "it creeps";
}

// The contact of a ball with a floor rotates with half its spin about the normal, and the
// displacement of rolling with it: roll = R w_y times the integral of the direction, which has
// turned by the angle a.
TEST(Rolling, ADisplacementOfRollingTurnsWithHalfTheSpin) {
  constexpr double w_y = 1, w_z = 50, time = 0.02;
  dem::ContactLaw law = rolling(1e3);
  law.friction = 0, law.zeta_r = 0;
  dem::NewParticle one = at_rest(0);
  one.position.z() -= 1e-4;
  one.held = true, one.spin = {0, w_y, w_z};
  Slope scene(law, test::sphere(r), one);
  scene.x_after(time);
  const double a = 0.5 * w_z * time;
  const Vec3 torque = scene.p[0].torque;
  const double size = 0.5 * law.k_n * r * r * w_y / (0.5 * w_z);  // k R^2 w_y over the rate of a
  constexpr double margin = 2e-3;                                 // half a step of 1000
  EXPECT_NEAR(torque.y(), -size * std::sin(a), margin * size);
  EXPECT_NEAR(torque.x(), size * (1 - std::cos(a)), margin * size);
}

// A ball spins on a floor that rotates about the same axis through the point of contact: only the
// difference of both spins is rolling.
TEST(Rolling, OnASurfaceThatRotatesOnlyTheRelativeSpinIsRolling) {
  constexpr double w_ball = 0.1, w_floor = 0.3;  // rad/s
  constexpr int steps = 1000;
  dem::ContactLaw law = rolling(1e3);
  law.friction = 0, law.zeta_r = 0;
  dem::NewParticle one = at_rest(0);
  one.position.z() -= 1e-4;
  one.held = true, one.spin.y() = w_ball;
  Slope scene(law, test::sphere(r), one);
  const Vec3 centre(one.position.x(), one.position.y(), 0);
  for (std::size_t n = 0; n < scene.floor.nodes(); ++n)
    scene.floor.motion[n] =
        Vec3(0, w_floor * steps * dt, 0).cross(scene.floor.position[n] - centre);
  scene.p.advance(steps * dt, steps);
  const double angle = (w_ball - w_floor) * steps * dt;
  const double size = 0.5 * law.k_n * r * r * angle;
  constexpr double margin = 2e-3;  // one step of 1000, tilt of the floor
  EXPECT_NEAR(scene.p[0].torque.y(), -size, margin * std::abs(size));
}

// The same for a pair: the displacement of rolling turns with the mean spin about the normal. The
// free sphere is so heavy that it keeps its spin.
TEST(Rolling, ADisplacementOfRollingTurnsWithTheMeanSpinOfAPair) {
  constexpr double w_y = 1, w_z = 20, time = 0.02, heavy = 1e12;  // heavy: kg/m^3
  dem::ContactLaw law = rolling(1e3);
  law.friction = law.zeta_n = law.zeta_r = 0;
  dem::Particles p(par::Comm::self(), test::one_material(law, heavy), {.gravity = 0},
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::sphere(r));
  std::vector<dem::NewParticle> two(2);
  two[0].held = true, two[0].spin = Vec3(0, w_y, w_z);
  two[1].id = 1, two[1].spin = Vec3(0, 0, 2 * w_z), two[1].position.z() = 2 * r - 1e-4;
  p.add(two);
  p.advance(time, 1000);
  const double a = 1.5 * w_z * time, reduced = r / 2;
  const double size = 0.5 * law.k_n * reduced * reduced * w_y / (1.5 * w_z);
  constexpr double margin = 2e-3;  // half a step of 1000
  EXPECT_NEAR(p[0].torque.y(), -size * std::sin(a), margin * size);
  EXPECT_NEAR(p[0].torque.x(), size * (1 - std::cos(a)), margin * size);
}

TEST(Rolling, ASphereRestsOnASlopeBelowTheLimitWithoutCreep) {
  Slope scene(rolling(), test::sphere(r), at_rest(0.9 * mu_r), 0.9 * mu_r);
  const double early = scene.x_after(1), late = scene.x_after(20);
  EXPECT_NEAR(early, at_rest(0.9 * mu_r).position.x(), 1e-4);  // m, below the springs' stretch
  EXPECT_NEAR(late, early, 1e-12);                             // m, in a million sub-steps
}

TEST(Rolling, ASphereRollsDownASlopeAboveTheLimit) {
  const double slope = 2 * mu_r, c = 1 / std::hypot(1, slope);
  Slope scene(rolling(), test::sphere(r), at_rest(slope), slope);
  const double start = scene.p[0].position.x(), seconds = 1;
  const double a = gravity * (slope - mu_r) * c / 1.4;  // along the slope
  EXPECT_NEAR(scene.x_after(seconds) - start, 0.5 * a * c * seconds * seconds, 2e-3 * a);
}

// Two spheres of different size that overlap, without friction: all torque is that of rolling.
struct TwoSpheres {
  dem::Particles p;
  TwoSpheres(const Vec3& spin_i, const Vec3& spin_j)
      : p(par::Comm::self(), test::one_material(law()), {.gravity = 0},
          test::box(Vec3::Constant(-1), Vec3::Constant(1))) {
    p.add_template(test::sphere(1));
    std::vector<dem::NewParticle> two(2);
    two[0].scale = 0.02, two[0].spin = spin_i;
    two[1].id = 1, two[1].scale = 0.01, two[1].spin = spin_j;
    two[1].position = (0.03 - delta) * Vec3(0.6, 0, 0.8);
    p.add(two);
    p.advance(1e-6, 1);
  }
  static dem::ContactLaw law() {
    dem::ContactLaw l = rolling();
    l.friction = l.zeta_n = 0;
    return l;
  }
  static constexpr double delta = 1e-5;  // m
};

TEST(Rolling, MomentsOfAPairAreOppositeAndCut) {
  const Vec3 n(0.6, 0, 0.8);
  const TwoSpheres two(Vec3(0, 2e3, 0) + 5.0 * n, Vec3::Zero());
  const double most = mu_r * 2e5 * TwoSpheres::delta * (0.02 * 0.01 / 0.03);  // Nm
  EXPECT_NEAR((two.p[0].torque - Vec3(0, -most, 0)).norm(), 0, 1e-6 * most);
  EXPECT_EQ(two.p[0].torque, -two.p[1].torque);
}

TEST(Rolling, ATurnOfThePairAsOneBodyIsNotResisted) {
  const TwoSpheres two(Vec3(3, 4, 5), Vec3(3, 4, 5));
  EXPECT_LT(two.p[0].torque.norm(), 1e-18);  // Nm, of 2e-4 at most
}

// Spheres, clumps and stones that collide in a periodic box.
dem::Particles crowd(const dem::Physics& physics) {
  dem::Domain domain = test::box(Vec3::Zero(), {0.16, 0.16, 0.16});
  domain.periodic = {true, true, true};
  dem::Particles p(par::Comm::self(), physics, {.largest_overlap = 10, .gravity = 0}, domain);
  p.add_template(test::sphere(0.5));
  p.add_template(test::clump());
  p.add_template(test::stone(1));
  auto all = test::lattice({5, 5, 5}, 0.032, 0.025, 3);
  for (dem::NewParticle& n : all) n.velocity *= 4;
  p.add(all);
  return p;
}

TEST_P(RollingLaw, EnergyNeverGrows) {
  dem::ContactLaw law = rolling(0.3);
  law.zeta_n = law.zeta_s = law.zeta_r = 0;  // only friction and rolling dissipate energy
  dem::Particles p = crowd(physics(law));
  p.advance(1e-9, 1);  // some overlap from the start
  const double first = p.totals().kinetic + p.totals().elastic;
  double before = first, contacts = 0;
  for (int k = 0; k < 200; ++k) {
    p.advance(10 * dt, 10);
    const dem::Totals t = p.totals();
    constexpr double margin = 1e-4;  // of all energy: second order in dt
    EXPECT_LT(t.kinetic + t.elastic, before + margin * first);
    before = t.kinetic + t.elastic;
    contacts += static_cast<double>(t.contacts);
  }
  EXPECT_GT(contacts, 1000);
  EXPECT_LT(before, 0.9 * first);
}

TEST_P(RollingLaw, AngularMomentumIsKept) {
  dem::Particles p(par::Comm::self(), physics(rolling(0.3)), {.largest_overlap = 10, .gravity = 0},
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::stone(1));
  p.add_template(test::clump());
  p.add_template(test::sphere(0.5));
  auto all = test::lattice({3, 2, 2}, 0.04, 0.05, 3);
  for (dem::NewParticle& n : all) n.velocity = 10 * (Vec3(0.06, 0.04, 0.04) - n.position);
  p.add(all);
  const auto angular_momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t b = 0; b < p.size(); ++b) {
      const dem::ParticleView v = p[b];
      const Vec3 i = v.mass * v.scale * v.scale *
                     (v.shape == 0   ? test::stone(1)
                      : v.shape == 1 ? test::clump()
                                     : test::sphere(0.5))
                         .gyration;
      sum += v.mass * v.position.cross(v.velocity) +
             v.attitude * i.cwiseProduct(v.attitude.conjugate() * v.spin);
    }
    return sum;
  };
  const Vec3 before = angular_momentum();
  std::int64_t contacts = 0;
  for (int k = 0; k < 100; ++k) p.advance(20 * dt, 20), contacts += p.totals().contacts;
  EXPECT_GT(contacts, 20);
  EXPECT_LT((angular_momentum() - before).norm(), 1e-12);  // kg m2/s, of terms of 1e-3
}

INSTANTIATE_TEST_SUITE_P(Laws, RollingLaw, testing::Bool());

TEST(Rolling, AManySidedStoneRollsLessFar) {
  const auto distance = [](std::uint64_t seed, double mu) {
    dem::NewParticle one = rolling_at(0.5);
    one.scale = 2 * r;
    Slope scene(rolling(mu), test::stone(seed, 60, 0.25), one, 0.1);
    const double start = scene.p[0].position.x();
    return scene.x_after(1) - start;
  };
  double freely = 0, hindered = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    freely += distance(seed, 0), hindered += distance(seed, 0.3);
  }
  EXPECT_GT(freely, 5 * 0.3);  // m
  EXPECT_LT(hindered, 0.3 * freely);
}

TEST(Rolling, ARockedBlockComesToRestOnItsFace) {
  const double half = 0.009;  // m
  dem::NewParticle one;
  one.position = Vec3(0.013, 0.007, half), one.spin = Vec3(0, 25, 0);
  Slope scene(rolling(0.1), test::brick({0.015, 0.012, half}, 0.0015), one);
  const auto tilt = [&] { return (scene.p[0].attitude * Vec3::UnitZ()).head<2>().norm(); };
  scene.x_after(0.01);
  EXPECT_GT(tilt(), 0.02) << "it has not rocked";
  const double rest = scene.x_after(2);
  EXPECT_LT(tilt(), 1e-5);
  EXPECT_NEAR(scene.p[0].position.z(), half, 1e-5);
  EXPECT_NEAR(scene.x_after(1), rest, 1e-12);
}

TEST(Rolling, ACoupleOnATriangleIsTheMomentAndWorksOnItsSpin) {
  Surface s;
  s.position = {{0.1, 0.02, 0.3}, {0.5, 0.1, 0.35}, {0.2, 0.4, 0.1}};
  s.triangles = {{0, 1, 2}};
  const Vec3 spin(0.01, -0.02, 0.03), moment(0.7, 0.2, -0.5);
  for (const Vec3& x : s.position) s.motion.push_back(Vec3(1, 2, 3) + spin.cross(x));
  const dem::Couple couple(s, 0, 0);
  EXPECT_LT((couple.spin() - spin).norm(), 1e-14);
  const auto forces = couple.forces(moment);
  Vec3 sum = Vec3::Zero(), resultant = Vec3::Zero();
  double work = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += forces[k], resultant += s.position[k].cross(forces[k]);
    work += forces[k].dot(s.motion[k]);
  }
  EXPECT_LT(sum.norm(), 1e-13);
  EXPECT_LT((resultant - moment).norm(), 1e-14);
  EXPECT_NEAR(work, moment.dot(spin), 1e-13);
}

TEST(Rolling, TheFloorGetsTheOppositeMoment) {
  for (const bool stone : {false, true}) {
    dem::NewParticle one = rolling_at(0.2);
    one.scale = stone ? 2 * r : 1;
    Slope scene(rolling(), stone ? test::stone(1, 60, 0.1) : test::sphere(r), one);
    scene.x_after(0.1);
    // A stone that is thinner than its initial height may still be falling.
    for (int k = 0; k < 20000 && scene.p.totals().contacts == 0; ++k) scene.p.advance(dt, 1);
    scene.floor.clear_load();
    scene.p.advance(dt, 1);
    EXPECT_GT(scene.p.totals().contacts, 0);
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t n = 0; n < scene.floor.nodes(); ++n) {
      const auto& load = scene.floor.load[n].force;
      const Vec3 f = scene.floor.load_quantum * Vec3(static_cast<double>(load[0]),
                                                     static_cast<double>(load[1]),
                                                     static_cast<double>(load[2]));
      force += f, moment += scene.floor.position[n].cross(f);
    }
    const dem::SurfaceAction action = scene.p.surface_action();
    EXPECT_LT((force - action.force).norm(), 1e-12 * action.force.norm());
    EXPECT_LT((moment - action.moment).norm(), 1e-12 * action.force.norm());
    const Vec3 of_particle = scene.p[0].position.cross(scene.p[0].force) + scene.p[0].torque;
    EXPECT_LT((moment + of_particle).norm(), 1e-12 * action.force.norm());
  }
}

}  // namespace
}  // namespace trackbed::rolling_test
