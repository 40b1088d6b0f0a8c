// Corners of clumps that break off: strengths, balances, and results that depend neither on ranks
// nor on a restart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "support/scene.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::breakage_test {
namespace {

constexpr double dt = 1e-5;  // s
constexpr double density = 2500;

// A ball of radius 1 with six corners of radius 0.35 that stand out by half of it.
dem::Template cornered() {
  std::vector<geom::Piece> pieces{geom::ball(Vec3::Zero(), 1)};
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      pieces.push_back(
          geom::ball(side * 0.85 * Vec3::Unit(axis) + 0.02 * axis * Vec3::UnitX(), 0.35));
  return geom::template_of(pieces);
}

dem::ContactLaw elastic() {
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e6;
  law.friction = 0.3;
  return law;
}

dem::BreakageParameters weak(double strength = 2e6) {
  dem::BreakageParameters p;
  p.material = "stone";
  p.strength = strength;
  p.growth_steps = 40;
  p.least_size = 2e-3;
  return p;
}

TEST(Strength, FollowsWeibullsLawAndTheSizeEffect) {
  dem::BreakageParameters p;
  p.strength = 10e6;
  constexpr int count = 20000;
  for (const double diameter : {0.010, 0.018}) {
    std::vector<double> drawn;
    for (int k = 0; k < count; ++k) drawn.push_back(dem::strength_of(p, k / 7, k % 7, diameter));
    std::sort(drawn.begin(), drawn.end());
    // At the characteristic strength 37 % survive. Largest deviation of the distribution: that of
    // Kolmogorov, 1.63/sqrt(n) at 1 % significance.
    const double scale = p.strength * std::pow(diameter, 2.5) / std::pow(p.diameter, 0.5);
    double furthest = 0;
    for (int k = 0; k < count; ++k) {
      const double broken =
          1 - std::exp(-std::pow(drawn[static_cast<std::size_t>(k)] / scale, p.weibull));
      furthest = std::max(furthest, std::abs(broken - (k + 0.5) / count));
    }
    EXPECT_LT(furthest, 1.63 / std::sqrt(count));
  }
  EXPECT_EQ(dem::strength_of(p, 5, 2, 0.01), dem::strength_of(p, 5, 2, 0.01));
  dem::BreakageParameters other = p;
  other.seed = 2;
  EXPECT_NE(dem::strength_of(p, 5, 2, 0.01), dem::strength_of(other, 5, 2, 0.01));
}

// Two clumps that collide head-on, corner to corner.
struct Collision {
  par::Comm comm = par::Comm::self();
  dem::Particles particles;
  explicit Collision(const dem::BreakageParameters& p, double speed = 4)
      : particles(comm, test::one_material(elastic(), density),
                  {.largest_overlap = 1, .gravity = 0},
                  test::box({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2})) {
    particles.set_breakage(p);
    particles.add_template(cornered());
    std::vector<dem::NewParticle> two(2);
    for (std::size_t k : {0U, 1U}) {
      const double side = k == 0 ? -1 : 1;
      two[k].id = static_cast<Id>(k), two[k].scale = 0.02;
      two[k].position = Vec3(side * 0.0245, k == 0 ? 0.001 : 0, 0);
      two[k].velocity = Vec3(-side * speed / 2, 0.3, 0.1);
      two[k].spin = Vec3(5, 3, side * 4);
    }
    particles.add(two);
    particles.set_surfaces({});
    particles.let_break(true);
  }
  void run(int windows) {
    for (int w = 0; w < windows; ++w) {
      particles.advance(4 * dt, 4);
      ASSERT_EQ(particles.trouble(), "");
    }
  }
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < particles.size(); ++i)
      sum += particles[i].mass * particles[i].position.cross(particles[i].velocity) +
             particles[i].angular_momentum;
    return sum;
  }
};

TEST(CornerBreakage, StrongStonesKeepTheirCorners) {
  Collision c(weak(1e12));
  c.run(300);
  EXPECT_EQ(c.particles.size(), 2U);
  EXPECT_EQ(c.particles.weak_pebbles(), 12);
  EXPECT_EQ(c.particles.broken().fragments + c.particles.broken().fines, 0);
}

// Masses to rounding; momentum to rounding; no energy is gained but that of growth against
// neighbours, which here have space.
TEST(CornerBreakage, BalancesMassMomentumAndEnergy) {
  Collision c(weak());
  const dem::Totals before = c.particles.totals();
  c.run(400);
  const dem::Totals after = c.particles.totals();
  const dem::BreakTotals broken = c.particles.broken();
  ASSERT_GE(broken.fragments, 1);
  EXPECT_EQ(c.particles.size(), 2U + static_cast<std::size_t>(broken.fragments));
  EXPECT_NEAR(after.mass + broken.fines_mass, before.mass, 1e-13 * before.mass);
  const double size = before.mass * 2;  // kg m/s, of one stone at 4 m/s
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * size);
  EXPECT_EQ(broken.fines, 0);
  EXPECT_LT(after.kinetic + after.elastic, before.kinetic * (1 + 1e-3));
  EXPECT_GT(broken.released, 0);
  for (const dem::Break& each : c.particles.breaks()) {
    EXPECT_GT(each.force, 0);
    EXPECT_LT(each.position.norm(), 0.05);
    EXPECT_NEAR(each.mass, density * std::numbers::pi / 6 * std::pow(each.diameter, 3),
                1e-12 * each.mass);
  }
}

// At birth a fragment touches nothing but its own stone, and the kinetic energy of the event is
// nearly kept: only spins are adjusted.
TEST(CornerBreakage, FragmentsAreBornWithoutPushing) {
  Collision c(weak());
  for (int w = 0; w < 400 && c.particles.broken().fragments == 0; ++w) c.run(1);
  ASSERT_GT(c.particles.broken().fragments, 0);
  const Id first = c.particles.breaks().front().fragment;
  double overlap = 0;
  c.particles.contacts([&](const dem::ContactView& contact) {
    if (contact.first == first || contact.second == first)
      overlap = std::max(overlap, contact.overlap);
  });
  EXPECT_LT(overlap, 2e-4);  // m; less than the travel of 4 m/s in one window of four sub-steps
  double turning = 0;        // J, of both stones: only spins change
  for (std::size_t i = 0; i < c.particles.size(); ++i)
    turning += 0.5 * c.particles[i].angular_momentum.dot(c.particles[i].spin);
  EXPECT_LT(std::abs(c.particles.broken().lost), 0.1 * turning);
}

TEST(CornerBreakage, AFragmentGrowsToTheMassThatWasLost) {
  Collision c(weak());
  for (int w = 0; w < 400 && c.particles.broken().fragments == 0; ++w) c.run(1);
  ASSERT_GT(c.particles.broken().fragments, 0);
  const auto fragment = [&]() -> dem::ParticleView {
    for (std::size_t i = 0; i < c.particles.size(); ++i)
      if (c.particles[i].fragment) return c.particles[i];
    throw std::runtime_error("no fragment");
  };
  const dem::ParticleView small = fragment();
  c.run(200);  // until it has left the gap between the two stones
  const dem::ParticleView grown = fragment();
  EXPECT_EQ(small.mass, grown.mass);
  EXPECT_LT(small.scale, 0.6 * grown.scale);
  EXPECT_EQ(small.volume, grown.volume);  // that of its mass
  EXPECT_NEAR(density * grown.volume, grown.mass, 1e-12 * grown.mass);
}

TEST(CornerBreakage, SmallFragmentsAreFines) {
  dem::BreakageParameters p = weak();
  p.least_size = 0.015;
  Collision c(p);
  const dem::Totals before = c.particles.totals();
  c.run(400);
  const dem::BreakTotals broken = c.particles.broken();
  EXPECT_EQ(c.particles.size(), 2U);
  EXPECT_GE(broken.fines, 1);
  EXPECT_NEAR(c.particles.totals().mass + broken.fines_mass, before.mass, 1e-13 * before.mass);
}

// The angular momentum about a fixed point changes by the moment of the mass that is moved, m d x v
// with a shift d of less than the radius of a pebble, 7 mm; as seen by an observer who moves with
// the stone it does not.
TEST(CornerBreakage, KeepsAngularMomentumInTheFrameOfTheStone) {
  Collision c(weak());
  const Vec3 before = c.angular_momentum();
  c.run(400);
  double moved = 0;  // kg m2/s
  for (const dem::Break& each : c.particles.breaks()) moved += each.mass * 0.007 * 2.1;
  EXPECT_LT(moved, 0.3 * before.norm());
  EXPECT_LT((c.angular_momentum() - before).norm(), moved);
}

// Clumps in disorder in a periodic cube whose corners break at any touch.
TEST(CornerBreakage, TenThousandEventsLoseNoMass) {
  if (par::Comm::world().size() > 1) GTEST_SKIP() << "the same on each rank";
  constexpr int n = 13;
  constexpr double spacing = 0.05;
  dem::Domain cube = test::box(Vec3::Zero(), Vec3::Constant(n * spacing));
  cube.periodic = {true, true, true};
  dem::Particles particles(par::Comm::self(), test::one_material(elastic(), density),
                           {.largest_overlap = 1, .gravity = 0}, cube);
  dem::BreakageParameters p = weak(10);
  p.least_size = 8e-3;  // some are fines
  particles.set_breakage(p);
  particles.add_template(cornered());
  auto all = test::lattice({n, n, n}, spacing, 0.02, 1);
  for (dem::NewParticle& stone : all) stone.velocity *= 10;
  particles.add(all);
  particles.set_surfaces({});
  particles.let_break(true);
  const dem::Totals before = particles.totals();
  const auto events = [&] {
    const dem::BreakTotals broken = particles.broken();
    return broken.fragments + broken.fines;
  };
  for (int w = 0; w < 5000 && events() < 10000; ++w) {
    particles.advance(8 * dt, 8);
    ASSERT_EQ(particles.trouble(), "");
  }
  const dem::BreakTotals broken = particles.broken();
  EXPECT_GE(events(), 10000);
  EXPECT_GT(broken.fines, 100);
  const dem::Totals after = particles.totals();
  // Rounding of as many sums as there are events.
  EXPECT_NEAR(after.mass + broken.fines_mass, before.mass, 1e-12 * before.mass);
  EXPECT_EQ(after.particles, before.particles + broken.fragments);
  double mass = 0;
  for (const dem::Break& each : particles.breaks()) mass += each.mass;
  EXPECT_EQ(static_cast<std::int64_t>(particles.breaks().size()), events());
  EXPECT_NEAR(mass, broken.fragment_mass + broken.fines_mass, 1e-11 * mass);
}

TEST(Remainder, OfTwoBallsIsTheOther) {
  const std::vector<geom::Piece> balls{geom::ball(Vec3::Zero(), 1),
                                       geom::ball(Vec3(0.9, 0.3, -0.2), 0.5)};
  const geom::Template whole = geom::template_of(balls);
  const geom::Remainder rest = geom::without_ball(whole, 1);
  // The tolerances are those of the integration of the union and of the lost part.
  EXPECT_NEAR(rest.stone.volume, 4 * std::numbers::pi / 3, 2e-3);
  EXPECT_LT(rest.stone.pieces[0].core.vertices[0].norm(), 2e-3);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(rest.stone.gyration[axis], 0.4, 2e-3);
  EXPECT_NEAR(rest.lost + rest.stone.volume, whole.volume, 1e-14);
  const Vec3 centre = (rest.lost * rest.lost_centre + rest.stone.volume * rest.centre);
  EXPECT_LT(centre.norm(), 1e-14);
}

// Clumps that are launched against each other and on a floor, in a periodic box.
struct Heap {
  Surface floor = test::floor_of(5, 0.7);
  dem::Particles particles;
  explicit Heap(const par::Comm& comm, double skin = 0)
      : particles(comm, test::one_material(elastic(), density),
                  {.skin = skin, .largest_overlap = 1}, domain()) {
    particles.set_breakage(weak(1e6));
  }
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.36, 0.24, 0.6});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm) {
    particles.add_template(cornered());
    particles.add_template(test::sphere());
    auto all = test::lattice({6, 4, 5}, 0.06, 0.02, 2);
    for (dem::NewParticle& p : all) p.velocity *= 6;
    particles.add(test::mine(comm, all));
    connect();
    particles.let_break(true);
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int windows, int moves = 0) {
    for (int w = 0; w < windows; ++w) {
      if (moves > 0 && w % moves == moves - 1) particles.repartition();
      particles.advance(4 * dt, 4);
      EXPECT_EQ(particles.trouble(), "");
    }
  }
};

// Lists change the speed of the program, not its results.
TEST(BreakingRanks, DoNotDependOnLists) {
  const par::Comm world = par::Comm::world();
  Heap usual(world), other(world, 2.5e-3);
  usual.pour(world), other.pour(world);
  usual.run(400), other.run(400, 50);
  EXPECT_EQ(usual.particles.state_hash(), other.particles.state_hash());
  EXPECT_GT(usual.particles.broken().fragments, 20);
  EXPECT_NE(usual.particles.rebuilds(), other.particles.rebuilds());
}

// Fragments go on growing into the space they find among all pieces.
TEST(BreakingRanks, DoNotDependOnListsWhileNothingBreaksAnyMore) {
  const par::Comm world = par::Comm::world();
  for (const int breaking : {140, 180, 220}) {  // windows; a fragment grows for ten of them
    Heap usual(world), other(world, 2.5e-3);
    for (Heap* heap : {&usual, &other}) {
      heap->pour(world), heap->run(breaking);
      heap->particles.let_break(false), heap->run(50);
    }
    EXPECT_EQ(usual.particles.state_hash(), other.particles.state_hash());
    EXPECT_GT(usual.particles.broken().fragments, 5);
  }
}

TEST(BreakingRanks, AreBitwiseIdentical) {
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  Heap shared(world), alone(self);
  shared.pour(world), alone.pour(self);
  const double mass = alone.particles.totals().mass;
  shared.run(400), alone.run(400);
  EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
  const dem::BreakTotals one = alone.particles.broken(), all = shared.particles.broken();
  EXPECT_GT(one.fragments, 20);
  EXPECT_EQ(one.fragments, all.fragments);
  EXPECT_EQ(one.fines_mass, all.fines_mass);
  EXPECT_EQ(one.fragment_mass, all.fragment_mass);
  EXPECT_EQ(one.released, all.released);
  EXPECT_EQ(one.lost, all.lost);
  EXPECT_NEAR(alone.particles.totals().mass + one.fines_mass, mass, 1e-12 * mass);
}

TEST(BreakingRanks, ContinueFromACheckpoint) {
  const par::Comm world = par::Comm::world();
  const std::string path = "breakage_" + std::to_string(world.size()) + ".h5";
  Heap whole(world), first(world), second(world);
  whole.pour(world), first.pour(world);
  // Stopped where pebbles are about to break and fragments grow.
  first.run(150), whole.run(150);
  {
    io::File file(world, path, io::Mode::create);
    first.particles.save(file, "p");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.particles.load(file, "p");
  }
  second.connect();
  EXPECT_GT(first.particles.broken().fragments, 0);
  second.run(200), whole.run(200);
  EXPECT_EQ(second.particles.state_hash(), whole.particles.state_hash());
  EXPECT_EQ(second.particles.broken().fragments, whole.particles.broken().fragments);
  EXPECT_EQ(second.particles.broken().lost, whole.particles.broken().lost);
  EXPECT_GT(whole.particles.broken().fragments, first.particles.broken().fragments);
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

}  // namespace
}  // namespace trackbed::breakage_test
