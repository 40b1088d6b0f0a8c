// Stones whose edges wear: shapes, the volume by the work of friction, balances, and results that
// depend neither on ranks nor on a restart.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "support/scene.hpp"
#include "support/stone_pairs.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::wear_test {
namespace {

constexpr double density = 2500;

dem::Template polyhedron(std::uint64_t seed) {
  return geom::template_of({geom::rounded_stone({.vertices = 16}, 0.05, seed)});
}

dem::ContactLaw elastic() {
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e7;
  law.friction = 0.3;
  return law;
}

dem::BreakageParameters soft(double hardness, double step = 2e-3) {
  dem::BreakageParameters p;
  p.material = "stone";
  p.wear = {.coefficient = 0.5, .hardness = hardness, .step = step};
  p.check_steps = 8;
  p.least_size = 5e-3;
  return p;
}

// A cube with the distance a of its faces and edges of radius r.
double rounded_cube(double a, double r) {
  const double s = a - 2 * r;
  return s * s * s + 6 * s * s * r + 3 * std::numbers::pi * s * r * r +
         4 * std::numbers::pi / 3 * r * r * r;
}

TEST(Worn, CubeHasRounderEdges) {
  constexpr double a = 1, r = 0.05;
  const geom::Template cube =
      geom::template_of({{test::cuboid_core(0.5 * Vec3::Constant(a - 2 * r)), r}});
  for (const double part : {1e-4, 1e-3, 1e-2, 1e-1}) {
    const auto rest = geom::worn(cube, part * cube.volume);
    ASSERT_TRUE(rest);
    EXPECT_EQ(rest->stone.volume, cube.volume - part * cube.volume);
    const double rounding = rest->stone.pieces[0].radius;
    EXPECT_NEAR(rounded_cube(a, r) - rounded_cube(a, rounding), part * cube.volume,
                1e-4 * part * cube.volume);
    // Its faces are where they were: along any of them it is as long as before.
    for (const geom::Face& face : rest->stone.pieces[0].core.faces)
      EXPECT_NEAR(geom::support_of(rest->stone, face.normal), a / 2, 1e-9);
  }
  // At the most, nearly the ball that the faces touch is left.
  EXPECT_FALSE(geom::worn(cube, cube.volume - std::numbers::pi / 6));
}

TEST(Worn, StoneStaysWithinItsFormerSelf) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    geom::Template stone = polyhedron(seed);
    const double first = stone.volume;
    int times = 0;
    for (; times < 20; ++times) {
      const auto rest = geom::worn(stone, 0.01 * first);
      if (!rest) break;
      EXPECT_GT(rest->stone.gyration.minCoeff(), 0);
      EXPECT_GT(rest->stone.pieces[0].radius, stone.pieces[0].radius);
      for (std::uint64_t k = 0; k < 50; ++k) {
        const Vec3 n =
            Vec3(uniform(k, 5) - 0.5, uniform(k, 6) - 0.5, uniform(k, 7) - 0.5).normalized();
        const double reach =
            n.dot(rest->centre) + geom::support_of(rest->stone, rest->axes.conjugate() * n);
        EXPECT_LT(reach, geom::support_of(stone, n) + 1e-9);
      }
      stone = rest->stone;
    }
    EXPECT_GT(times, 3) << "seed " << seed;
  }
}

// A block that slides on a floor until it rests. Friction takes its kinetic energy, but for that of
// the dust; the wear of the last part of a step is still to come.
TEST(Wear, OnAFloorFollowsTheWorkOfFriction) {
  constexpr double dt = 4e-6, speed = 0.4;
  Surface floor = test::floor_of(1, 0.5);
  const dem::BreakageParameters p = soft(2e4, 1e-3);
  dem::Particles particles(par::Comm::self(), test::one_material(elastic(), density),
                           {.largest_overlap = 1},
                           test::box(Vec3(-0.4, -0.4, -0.05), Vec3(0.4, 0.4, 0.1)));
  particles.set_breakage(p);
  const dem::Template block =
      geom::template_of({{test::cuboid_core(0.5 * Vec3(0.05, 0.04, 0.02)), 0.002}});
  particles.add_template(block);
  dem::NewParticle one;
  one.position = Vec3(-0.1, 0, 0);
  // Its shortest axis is upright.
  const double up = geom::support_of(block, Vec3::UnitX()),
               side = geom::support_of(block, Vec3::UnitZ());
  const bool upright = side < up;
  one.attitude = upright ? Quat::Identity() : Quat::FromTwoVectors(Vec3::UnitX(), Vec3::UnitZ());
  one.position.z() = std::min(up, side);
  one.velocity = Vec3(speed, 0, 0);
  particles.add(std::vector{one});
  particles.set_surfaces({&floor});
  particles.let_break(true);
  const dem::Totals before = particles.totals();
  for (int w = 0; w < 6000; ++w) {
    particles.advance(8 * dt, 8);
    ASSERT_EQ(particles.trouble(), "");
  }
  const dem::Totals after = particles.totals();
  const dem::BreakTotals broken = particles.broken();
  EXPECT_GT(broken.wears, 3);
  EXPECT_EQ(broken.wears, static_cast<std::int64_t>(particles.breaks().size()));
  EXPECT_EQ(broken.fines_mass, broken.dust_mass);
  EXPECT_NEAR(after.mass + broken.dust_mass, before.mass, 1e-13 * before.mass);
  const double work = before.kinetic - after.kinetic - broken.lost;
  EXPECT_GT(work, 0.9 * before.kinetic);
  const double expected = density * p.wear.coefficient * work / p.wear.hardness;
  EXPECT_LE(broken.dust_mass, 1.01 * expected);
  EXPECT_GT(broken.dust_mass, 0.99 * expected - p.wear.step * before.mass);
}

// Both stones of a contact wear by the same volume. Edges recede while they are loaded, which takes
// some of the elastic energy, too: the less, the harder the stones.
TEST(Wear, OfACollisionFollowsTheEnergyLost) {
  constexpr double dt = 1e-6;
  const dem::BreakageParameters p = soft(2e8, 2e-7);
  for (std::uint64_t seed = 1; seed <= 7; seed += 2) {
    dem::Particles particles(par::Comm::self(), test::one_material(elastic(), density),
                             {.largest_overlap = 1, .gravity = 0},
                             test::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)));
    particles.set_breakage(p);
    std::vector<dem::NewParticle> two(2);
    for (std::size_t k : {0U, 1U}) {
      const double side = k == 0 ? -1 : 1;
      particles.add_template(polyhedron(seed + k));
      two[k].id = static_cast<Id>(k), two[k].shape = static_cast<int>(k), two[k].scale = 0.03;
      two[k].position = Vec3(side * 0.022, side * -0.004, 0);
      two[k].velocity = Vec3(-side * 2, side * 0.5, 0.1);
      two[k].spin = Vec3(5, 3, 80);
    }
    particles.add(two);
    particles.set_surfaces({});
    particles.let_break(true);
    const dem::Totals before = particles.totals();
    for (int w = 0; w < 1000; ++w) {
      particles.advance(8 * dt, 8);
      ASSERT_EQ(particles.trouble(), "");
    }
    const dem::Totals after = particles.totals();
    const dem::BreakTotals broken = particles.broken();
    const double work = before.kinetic - after.kinetic - after.elastic - broken.lost;
    const double expected = 2 * density * p.wear.coefficient * work / p.wear.hardness;
    EXPECT_NEAR(after.mass + broken.dust_mass, before.mass, 1e-13 * before.mass);
    EXPECT_GT(broken.wears, 2) << "seed " << seed;
    // Two steps are still to come.
    EXPECT_NEAR(broken.dust_mass, expected, 0.05 * expected + p.wear.step * before.mass)
        << "seed " << seed;
  }
}

// Polyhedra that wear and compounds that do not, launched against each other and on a floor, in a
// periodic box.
struct Heap {
  Surface floor = test::floor_of(5, 0.7);
  dem::Particles particles;
  explicit Heap(const par::Comm& comm, double skin = 0)
      : particles(comm, test::one_material(elastic(), density),
                  {.skin = skin, .largest_overlap = 1}, domain()) {
    particles.set_breakage(soft(3e5));
  }
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.30, 0.30, 0.6});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm) {
    particles.add_template(polyhedron(5));
    const geom::Convex core = geom::rounded_stone({.vertices = 16}, 0.05, 7).core;
    particles.add_template(
        geom::template_of({{geom::sliced(core, 2)[0], 0.05}, {geom::sliced(core, 2)[1], 0.05}}));
    auto all = test::lattice({5, 5, 2}, 0.06, 0.045, 2);
    for (dem::NewParticle& p : all) p.velocity *= 12;
    particles.add(test::mine(comm, all));
    connect();
    particles.let_break(true);
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int windows, int moves = 0) {
    for (int w = 0; w < windows; ++w) {
      if (moves > 0 && w % moves == moves - 1) particles.repartition();
      particles.advance(16e-6, 4);
      EXPECT_EQ(particles.trouble(), "");
    }
  }
};

TEST(WearRanks, DoNotDependOnListsAndRanks) {
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  Heap shared(world, 2.5e-3), alone(self);
  shared.pour(world), alone.pour(self);
  const double mass = alone.particles.totals().mass;
  shared.run(250, 50), alone.run(250);
  EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
  const dem::BreakTotals one = alone.particles.broken(), all = shared.particles.broken();
  EXPECT_GT(one.wears, 10);
  EXPECT_EQ(one.wears, all.wears);
  EXPECT_EQ(one.dust_mass, all.dust_mass);
  EXPECT_EQ(one.lost, all.lost);
  EXPECT_NEAR(alone.particles.totals().mass + one.fines_mass, mass, 1e-12 * mass);
}

TEST(WearRanks, ContinuesFromACheckpoint) {
  const par::Comm world = par::Comm::world();
  const std::string path = "wear_" + std::to_string(world.size()) + ".h5";
  Heap probe(world), whole(world), second(world);
  probe.pour(world), whole.pour(world);
  int windows = 0;
  for (; windows < 250 && probe.particles.broken().wears < 3; ++windows) probe.run(1);
  whole.run(windows - 1);  // stones that wear in the next window are in the checkpoint
  {
    io::File file(world, path, io::Mode::create);
    whole.particles.save(file, "p");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.particles.load(file, "p");
  }
  second.connect();
  const dem::BreakTotals then = whole.particles.broken();
  second.run(1), whole.run(1);
  EXPECT_GT(probe.particles.broken().wears, then.wears);
  EXPECT_EQ(second.particles.broken().wears, probe.particles.broken().wears);
  second.run(100), whole.run(100);
  EXPECT_EQ(second.particles.state_hash(), whole.particles.state_hash());
  EXPECT_EQ(second.particles.broken().dust_mass, whole.particles.broken().dust_mass);
  EXPECT_GT(whole.particles.broken().wears, probe.particles.broken().wears);
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

}  // namespace
}  // namespace trackbed::wear_test
