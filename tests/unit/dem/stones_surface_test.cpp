// Stones on surfaces: a face acts as one plane however it is cut; energy is kept when the closest
// feature changes; stones at rest stay at rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/stones.hpp"
#include "trackbed/core/rotation.hpp"

namespace trackbed::stones_surface_test {
namespace {

const Vec3 half(0.03, 0.02, 0.015);  // m, of the brick
constexpr double rounding = 0.002;   // m
constexpr double density = 2500;     // kg/m^3

dem::ContactLaw elastic() {
  dem::ContactLaw law;
  law.k_n = 1e6, law.k_s = 0, law.friction = 0;
  return law;
}

dem::ContactLaw rough(double damping = 0.3) {
  dem::ContactLaw law;
  law.k_n = 1e6, law.k_s = 0.8e6, law.friction = 0.5;
  law.zeta_n = law.zeta_s = damping;
  return law;
}

dem::NewParticle lying(double height) {
  dem::NewParticle one;
  one.position = Vec3(0.013, 0.021, height);
  return one;
}

// One stone above a surface.
struct Stage {
  dem::Particles particles;
  Surface surface;
  double dt;  // s, a tenth of sqrt(m/k)

  Stage(const dem::Template& shape, const dem::NewParticle& one, const Surface& below,
        const dem::ContactLaw& law, double g = gravity)
      : particles(par::Comm::self(), test::one_material(law, density),
                  {.largest_overlap = 3, .gravity = g},
                  test::box(Vec3::Constant(-3), Vec3::Constant(3))),
        surface(below),
        dt(0.1 * std::sqrt(density * shape.volume / law.k_n)) {
    particles.add_template(shape);
    particles.add(std::span(&one, 1));
    particles.set_surfaces({&surface});
  }
  Stage(const Stage&) = delete;
  void run(double seconds, double step) {
    const int steps = static_cast<int>(seconds / step);
    for (int done = 0; done < steps; done += 100) particles.advance(100 * step, 100);
    EXPECT_EQ(particles.trouble(), "");
  }
  void run(double seconds) { run(seconds, dt); }
  dem::ParticleView stone() const { return particles[0]; }
  double energy() const {
    const dem::Totals t = particles.totals();
    return t.kinetic + t.potential + t.elastic;
  }
};

// Sine of the angle between the brick's flat side and the plane.
double lean(const dem::ParticleView& p) {
  return (p.attitude * Vec3::UnitZ()).cross(Vec3::UnitZ()).norm();
}

TEST(StoneOnSurface, TrianglesActAsOnePlane) {
  const auto launched = [](int n) {
    dem::NewParticle one = lying(0.03);
    one.velocity = Vec3(0.5, 0.3, -0.4), one.spin = Vec3(3, -2, 5);
    Stage stage(test::brick(half, rounding), one, test::floor_of(n, 0.8), rough(0.1));
    stage.run(0.2);
    return stage.stone();
  };
  const dem::ParticleView whole = launched(1);
  for (const int n : {7, 40}) {
    const dem::ParticleView cut = launched(n);
    EXPECT_LT((cut.position - whole.position).norm(), 1e-12) << n;  // m: rounding
    EXPECT_LT((cut.spin - whole.spin).norm(), 1e-9) << n;
  }
}

TEST(StoneOnSurface, ADroppedBrickComesToRestAndTiltsBack) {
  dem::NewParticle one = lying(0.04);
  one.attitude = Quat(1, 0.1, 0.07, 0.2).normalized();
  Stage stage(test::brick(half, rounding), one, test::floor_of(9, 0.5), rough());
  const double drop = stage.stone().mass * gravity * 0.025;
  stage.run(1.5);
  EXPECT_LT(stage.particles.totals().kinetic, 1e-12 * drop);
  EXPECT_LT(lean(stage.stone()), 1e-6);
  EXPECT_NEAR(stage.stone().position.z(), half.z(), 2e-5);
  one = lying(half.z());
  one.spin = Vec3(0, 20, 0);  // rad/s, lifts one side by some degrees
  Stage pushed(test::brick(half, rounding), one, test::floor_of(9, 0.5), rough());
  pushed.run(0.01);
  EXPECT_GT(lean(pushed.stone()), 0.01);
  pushed.run(1.5);
  EXPECT_LT(lean(pushed.stone()), 1e-6);
  EXPECT_LT(pushed.particles.totals().kinetic, 1e-12 * drop);
}

// Relative change of energy in one elastic collision without gravity: of a face, an edge or a
// corner of a brick, or of an irregular stone in a random attitude.
enum class Hit { face, edge, corner, stone };
double collision(Hit hit, std::uint64_t key, double share) {
  const auto some = [&](std::uint64_t n) { return uniform(n, key) - 0.5; };
  dem::NewParticle one = lying(0.043);
  const Quat almost(1, 0.02 * some(1), 0.02 * some(2), some(3));
  if (hit == Hit::face) one.attitude = almost.normalized();
  if (hit == Hit::edge) one.attitude = Quat(1, 0.4, 0.01 * some(2), 0).normalized();
  if (hit == Hit::corner) one.attitude = Quat(1, 0.4, 0.3, some(3)).normalized();
  if (hit == Hit::stone) one.attitude = Quat(some(4), some(1), some(2), some(3)).normalized();
  one.velocity = Vec3(some(5), some(6), -1), one.spin = 10 * Vec3(some(7), some(8), some(9));
  Stage stage(
      hit == Hit::stone ? test::irregular(0.02, rounding, key) : test::brick(half, rounding), one,
      test::floor_of(12, 0.5), elastic(), 0);
  const double before = stage.energy();
  stage.run(0.06, share * stage.dt);
  EXPECT_GT(stage.stone().velocity.z(), 0) << key;
  return std::abs(stage.energy() / before - 1);
}

TEST(StoneOnSurface, ElasticCollisionsKeepTheirEnergy) {
  constexpr int count = 24;
  for (const Hit hit : {Hit::face, Hit::edge, Hit::corner, Hit::stone}) {
    const auto errors = [&](double share) {
      std::vector<double> all;
      for (std::uint64_t n = 0; n < count; ++n) all.push_back(collision(hit, n, share));
      std::sort(all.begin(), all.end());
      return all;
    };
    const std::vector<double> coarse = errors(1), fine = errors(0.25);
    const double order = std::log(coarse[count / 2] / fine[count / 2]) / std::log(4.0);
    std::printf("hit %d: median %.2g, largest %.2g (a quarter: %.2g), order %.2f\n",
                static_cast<int>(hit), coarse[count / 2], coarse.back(), fine.back(), order);
    // A face that strikes nearly flat rocks from one corner to the next within a sub-step: the
    // point of the force moves by (p - 1) times the displacement, on an effective mass of a fifth
    // of m.
    EXPECT_LT(coarse[count / 2], hit == Hit::face ? 3e-3 : 5e-4);
    EXPECT_LT(coarse.back(), hit == Hit::face ? 1.5e-2 : 5e-3);
    EXPECT_LT(fine.back(), 1e-3);
    // Rocking is of second order, corrected ends of contacts of third and more.
    EXPECT_GT(order, 1.8);
    EXPECT_LT(order, 5);
  }
}

// Largest change of energy while a brick slides over the rim of a block without friction, tips and
// falls along its side, over the work of its weight along its height.
double error_over_the_rim(int n, double share) {
  dem::NewParticle one;
  const dem::Template brick = test::brick(half, rounding);
  // At the depth at which four equal corners carry it, so that it does not bounce on the block:
  // many small bounces accumulate errors of the second order by chance.
  const double sunk = density * brick.volume * gravity / (std::cbrt(4.0) * elastic().k_n);
  one.position = Vec3(0.07, 0.011, 0.1 + half.z() - sunk);
  one.velocity = Vec3(0.3, 0, 0), one.attitude = Quat(1, 0, 0, 0.15).normalized();
  Stage stage(brick, one, test::block_of({0.1, 0.3, 0.1}, n), elastic());
  stage.particles.advance(1e-12, 1);  // finds the contacts
  const double before = stage.energy();
  double worst = 0;
  for (int k = 0; k < 60; ++k) {
    stage.run(0.005, share * stage.dt);
    worst = std::max(worst, std::abs(stage.energy() - before));
  }
  EXPECT_LT(stage.stone().position.z(), 0.08) << n;
  EXPECT_GT(lean(stage.stone()), 0.2) << n;
  return worst / (stage.stone().mass * gravity * half.z());
}

TEST(StoneOnSurface, TurningOverASharpEdgeKeepsTheEnergy) {
  for (const int n : {1, 6}) {
    const double coarse = error_over_the_rim(n, 0.5), fine = error_over_the_rim(n, 0.125);
    std::printf("rim: %.2g %.2g\n", coarse, fine);
    EXPECT_LT(coarse, 1e-7) << n;
    EXPECT_LT(fine, coarse / 8) << n;    // second order: a sixteenth
    EXPECT_GT(fine, coarse / 256) << n;  // fourth
  }
}

TEST(StoneOnSurface, ABrickRestsHalfOverAnEdgeAndOnACorner) {
  for (const int n : {1, 6})
    for (const double y : {0.0, 0.29}) {  // over an edge; over a corner of the block
      dem::NewParticle one;
      one.position = Vec3(0.088, y, 0.1 + half.z() + 0.001);
      one.attitude = Quat(1, 0, 0, 0.3).normalized();
      Stage stage(test::brick(half, rounding), one, test::block_of({0.1, 0.3, 0.1}, n), rough());
      stage.run(1);
      EXPECT_LT(stage.particles.totals().kinetic, 1e-15);
      EXPECT_LT(lean(stage.stone()), 1e-2);
      EXPECT_NEAR(stage.stone().position.z(), 0.1 + half.z(), 5e-5);
      EXPECT_NEAR(stage.stone().force.z(), stage.stone().mass * gravity, 1e-6);
    }
}

TEST(StoneOnSurface, ACornerOfTheSurfaceHoldsAFace) {
  // The middle of a face of a brick is on the corner of a block set on its tip.
  Surface tip = test::block_of(Vec3::Constant(0.1), 1);
  const Quat up = rotation_onto(Vec3::Ones(), Vec3::UnitZ());
  for (Vec3& x : tip.position) x = up * x;
  dem::NewParticle one;
  const double overlap = 1e-4;
  one.position = Vec3(0, 0, 0.1 * std::sqrt(3.0) + half.z() - overlap);
  Stage stage(test::brick(half, rounding), one, tip, elastic(), 0);
  stage.particles.advance(1e-9, 1);
  EXPECT_NEAR(stage.stone().force.z(), 1e6 * overlap, 1e-3);
  EXPECT_LT(stage.stone().torque.norm(), 1e-9);
}

TEST(StoneOnSurface, ASlidingBrickStopsAtCoulombsDistance) {
  const double v = 0.5, mu = 0.5, distance = v * v / (2 * mu * gravity);
  for (const int n : {1, 40}) {
    dem::NewParticle one = lying(half.z());
    one.velocity = Vec3(v, 0, 0);
    Stage stage(test::brick(half, rounding), one, test::floor_of(n, 0.8), rough());
    stage.run(0.05);
    EXPECT_NEAR(stage.stone().velocity.x(), v - mu * gravity * 0.05, 0.02 * v) << n;
    stage.run(0.5);
    EXPECT_NEAR(stage.stone().position.x() - 0.013, distance, 0.02 * distance) << n;
    EXPECT_LT(stage.particles.totals().kinetic, 1e-12 * stage.stone().mass) << n;
  }
}

TEST(StoneOnSurface, ASpinningBrickIsStopped) {
  dem::NewParticle one = lying(half.z());
  one.spin = Vec3(0, 0, 20);
  Stage stage(test::brick(half, rounding), one, test::floor_of(9, 0.5), rough());
  stage.run(1);
  EXPECT_LT(stage.stone().spin.norm(), 1e-6);
  EXPECT_LT(lean(stage.stone()), 1e-6);
}

// The two sides of a shallow valley are one patch. Sides that close upon the stone have no mean
// motion; without friction only their motion along their normals counts, so that they act on it
// like a valley that becomes deeper.
TEST(StoneOnSurface, SidesOfAPatchThatCloseActLikeARisingOne) {
  constexpr double slope = 0.1, dt = 1e-9, depth = 1e-4;  // -, s, m
  constexpr double pace = 40;                             // 1/s, 0.1 m/s along the normals
  const auto force = [&](const auto& velocity) {
    dem::ContactLaw law = rough();
    law.friction = 0, law.k_s = 0;
    Surface valley = test::floor_of(4, 0.5);
    for (Vec3& x : valley.position) x.z() = slope * std::abs(x.x());
    const double reach = half.x() - rounding;
    dem::NewParticle one;
    one.position.z() =
        half.z() - rounding + slope * reach + (rounding - depth) * std::hypot(1, slope);
    Stage stage(test::brick(half, rounding), one, valley, law, 0);
    for (std::size_t n = 0; n < stage.surface.nodes(); ++n)
      stage.surface.motion[n] = dt * velocity(stage.surface.position[n]);
    stage.particles.advance(dt, 1);
    return stage.stone().force.z();
  };
  const double at_rest = force([](const Vec3&) { return Vec3(0, 0, 0); });
  const double closing = force([](const Vec3& x) { return Vec3(-pace * x.x(), 0, 0); });
  const double rising =
      force([](const Vec3& x) { return Vec3(0, 0, slope * pace * std::abs(x.x())); });
  EXPECT_GT(rising, 1.1 * at_rest);
  constexpr double tilt = pace * dt;  // of the sides in a step, over the slope
  EXPECT_NEAR(closing, rising, tilt * rising);
}

TEST(StoneOnSurface, AStoneBelowTheSurfaceComesBack) {
  // A core whose corners, or all of it, are below the surface.
  for (const double depth : {0.003, 0.02}) {
    dem::NewParticle one = lying(half.z() - depth);
    one.attitude = Quat(1, 0.1, 0.05, 0).normalized();
    dem::ContactLaw soft = rough(1);
    soft.k_n = soft.k_s = 1e4;
    dem::Particles p(par::Comm::self(), test::one_material(soft), {.largest_overlap = 100},
                     test::box(Vec3::Constant(-3), Vec3::Constant(3)));
    p.add_template(test::brick(half, rounding));
    p.add(std::span(&one, 1));
    Surface floor = test::floor_of(9, 0.5);
    p.set_surfaces({&floor});
    for (int k = 0; k < 200; ++k) p.advance(1e-2, 40);
    EXPECT_GT(p[0].position.z(), half.z() - 1e-3) << depth;  // on any of its sides
    EXPECT_LT(p[0].position.z(), half.x() + 1e-3) << depth;
    EXPECT_LT(p[0].velocity.norm(), 1e-6) << depth;
  }
}

TEST(StoneOnSurface, ACornerThatIsLostBehindASurfaceIsReported) {
  // Too soft for its speed: half of the brick penetrates the floor.
  dem::NewParticle one = lying(half.z() + 0.001);
  one.attitude = Quat(1, 0.2, 0.1, 0).normalized(), one.position.z() += 0.01;
  one.velocity = Vec3(0, 0, -10);
  dem::ContactLaw soft = elastic();
  soft.k_n = 1e4;
  dem::Particles p(par::Comm::self(), test::one_material(soft, density),
                   {.largest_overlap = 100, .gravity = 0},
                   test::box(Vec3::Constant(-3), Vec3::Constant(3)));
  p.add_template(test::brick(half, rounding));
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(9, 0.5);
  p.set_surfaces({&floor});
  std::string trouble;
  for (int k = 0; k < 200 && trouble.empty(); ++k) p.advance(2e-4, 10), trouble = p.trouble();
  EXPECT_EQ(trouble.rfind("a piece of particle 0 at (", 0), 0u) << trouble;
  EXPECT_NE(trouble.find(") m has penetrated the surface \"floor\" by more than"),
            std::string::npos)
      << trouble;
}

TEST(StoneOnSurface, TheSurfaceGetsTheOppositeForceAndMoment) {
  dem::NewParticle one = lying(0.02);
  one.attitude = Quat(1, 0.3, 0.2, 0.1).normalized();
  one.velocity = Vec3(0.6, 0.3, -0.8), one.spin = Vec3(5, 2, 9);
  Surface floor = test::floor_of(20, 0.5);
  for (Vec3& x : floor.position) x.z() += 2e-3 * std::sin(20 * x.x()) * std::cos(17 * x.y());
  Stage stage(test::brick(half, rounding), one, floor, rough());
  constexpr int steps = 10;
  double largest = 0;
  for (int window = 0; window < 60; ++window) {
    Surface& s = stage.surface;
    s.clear_load();
    for (std::size_t n = 0; n < s.nodes(); ++n) {
      s.position[n] += s.motion[n];
      s.motion[n] = 1e-6 * Vec3(std::sin(9 * s.position[n].y()), 1, std::cos(5.0 * window));
    }
    stage.particles.advance(steps * stage.dt, steps);
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    double work = 0;
    for (std::size_t n = 0; n < s.nodes(); ++n) {
      Vec3 sum, first;
      for (int a = 0; a < 3; ++a) {
        sum[a] = static_cast<double>(s.load[n].force[static_cast<std::size_t>(a)]) * s.load_quantum;
        first[a] =
            static_cast<double>(s.load[n].first[static_cast<std::size_t>(a)]) * s.load_quantum;
      }
      force += sum, moment += s.position[n].cross(sum) + s.motion[n].cross(first);
      work += sum.dot(s.motion[n]) / steps;
    }
    const dem::SurfaceAction& action = stage.particles.surface_action();
    largest = std::max(largest, action.force.norm());
    const double scale = std::max(1.0, action.force.norm());
    EXPECT_LT((force - action.force).norm(), 1e-9 * scale) << window;
    EXPECT_LT((moment - action.moment).norm(), 1e-9 * scale) << window;
    EXPECT_NEAR(work, action.work, 1e-14 * scale) << window;
  }
  EXPECT_GT(largest, 100);  // N, the sum over the window's sub-steps
}

}  // namespace
}  // namespace trackbed::stones_surface_test
