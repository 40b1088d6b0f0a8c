// Stones with corners that split or lose corners: strengths, parts, balances, and results that
// depend neither on ranks nor on a restart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "support/scene.hpp"
#include "support/stone_pairs.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::splitting_test {
namespace {

constexpr double dt = 2e-6;  // s
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

dem::BreakageParameters weak(double splitting, double cutting = 0) {
  dem::BreakageParameters p;
  p.material = "stone";
  p.splitting.strength = splitting;
  p.cutting.strength = cutting;
  p.check_steps = 8;
  p.least_size = 5e-3;
  return p;
}

double ball(double diameter) { return std::numbers::pi / 6 * std::pow(diameter, 3); }

TEST(SplittingStrength, FollowsWeibullsLawAndTheSizeEffect) {
  dem::BreakageParameters p;
  p.splitting = {.strength = 20e6, .diameter = 0.03, .weibull = 2.5};
  constexpr int count = 20000;
  for (const double diameter : {0.02, 0.05}) {
    std::vector<double> drawn;
    for (int k = 0; k < count; ++k)
      drawn.push_back(dem::splitting_strength(p, k / 3, k % 3, diameter));
    std::sort(drawn.begin(), drawn.end());
    // A stone survives if each of its parts of equal volume does: P = exp(-(d/d0)^3 (s/s0)^m).
    // Largest deviation of the distribution: that of Kolmogorov, 1.63/sqrt(n) at 1 % significance.
    double furthest = 0;
    for (int k = 0; k < count; ++k) {
      const double stress = drawn[static_cast<std::size_t>(k)] / p.splitting.strength;
      const double survive = std::exp(-std::pow(diameter / p.splitting.diameter, 3) *
                                      std::pow(stress, p.splitting.weibull));
      furthest = std::max(furthest, std::abs(1 - survive - (k + 0.5) / count));
    }
    EXPECT_LT(furthest, 1.63 / std::sqrt(count));
  }
}

// A cube of side a with edges of radius r, cut in the middle, gives two boxes with cores of the
// sides a - 2r, a - 2r and a/2 - 2r.
TEST(PartBelow, OfARoundedCubeIsARoundedBox) {
  constexpr double a = 1, r = 0.1;
  const geom::Template cube =
      geom::template_of({{test::cuboid_core(0.5 * Vec3::Constant(a - 2 * r)), r}});
  const geom::Template half =
      geom::template_of({{test::cuboid_core(0.5 * Vec3(a - 2 * r, a - 2 * r, a / 2 - 2 * r)), r}});
  const Vec3 z = Vec3::UnitZ();
  const auto below = geom::part_below(cube, z, 0), above = geom::part_below(cube, -z, 0);
  ASSERT_TRUE(below && above);
  EXPECT_NEAR(below->stone.volume, half.volume, 1e-12);
  EXPECT_NEAR(above->stone.volume, half.volume, 1e-12);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(below->stone.gyration[k], half.gyration[k], 1e-12) << "moment " << k;
  EXPECT_NEAR(below->centre.z(), -a / 4, 1e-12);
  EXPECT_NEAR(below->centre.z() + geom::support_of(below->stone, below->axes.conjugate() * z), 0,
              1e-12);
  EXPECT_FALSE(geom::part_below(cube, z, -a));
  EXPECT_NEAR(geom::part_below(cube, z, a)->stone.volume, cube.volume, 1e-12);
}

TEST(PartBelow, OfAnyStoneStaysWithinIt) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const geom::Template whole = polyhedron(seed);
    const Vec3 normal =
        Vec3(uniform(seed, 1) - 0.5, uniform(seed, 2) - 0.5, uniform(seed, 3) - 0.5).normalized();
    const double offset = 0.3 * (uniform(seed, 4) - 0.5);
    double volume = 0;
    for (const double side : {1.0, -1.0}) {
      const auto part = geom::part_below(whole, side * normal, side * offset);
      ASSERT_TRUE(part);
      volume += part->stone.volume;
      for (int k = 0; k < 50; ++k) {
        const auto draw = static_cast<std::uint64_t>(k);
        const Vec3 n = Vec3(uniform(draw, 5) - 0.5, uniform(draw, 6) - 0.5, uniform(draw, 7) - 0.5)
                           .normalized();
        const double reach =
            n.dot(part->centre) + geom::support_of(part->stone, part->axes.conjugate() * n);
        EXPECT_LT(reach, geom::support_of(whole, n) + 1e-12);
      }
    }
    EXPECT_LT(volume, whole.volume);
    EXPECT_GT(volume, 0.85 * whole.volume);  // what is lost along the edges of the cut
  }
}

// Planes through corners, along faces and anywhere; of parts of parts.
TEST(PartBelow, AcceptsAnyPlane) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    geom::Template stone = polyhedron(seed % 8);
    for (std::uint64_t k = 0; k < 25; ++k) {
      const geom::Convex& core = stone.pieces[0].core;
      const auto draw = [&](std::uint64_t key) { return uniform(seed, 100 * k + key); };
      const auto some = [&](const auto& list) {
        return list[static_cast<std::size_t>(draw(9) * static_cast<double>(list.size()))];
      };
      Vec3 normal = Vec3(draw(1) - 0.5, draw(2) - 0.5, draw(3) - 0.5).normalized();
      if (k % 3 == 1) normal = some(core.faces).normal;
      double offset = 0.2 * (draw(4) - 0.5);
      if (k % 3 == 2) offset = normal.dot(some(core.vertices)) + stone.pieces[0].radius;
      if (k % 5 == 0) offset += 1e-8 * (draw(5) - 0.5);
      const auto part = geom::part_below(stone, normal, offset);
      if (!part) continue;
      EXPECT_LE(part->stone.volume, stone.volume * (1 + 1e-9));
      EXPECT_GT(part->stone.gyration.minCoeff(), 0);
      if (part->stone.volume > 0.02) stone = part->stone;
    }
  }
}

TEST(SectionArea, OfACubeIsThatOfItsSquareAndHexagon) {
  const geom::Convex cube = test::cuboid_core(0.5 * Vec3::Ones());
  EXPECT_NEAR(geom::section_area(cube, Vec3::UnitX(), 0.2), 1, 1e-14);
  const Vec3 diagonal = Vec3::Ones().normalized();
  EXPECT_NEAR(geom::section_area(cube, diagonal, 0), 3 * std::sqrt(3.0) / 4, 1e-14);
  EXPECT_EQ(geom::section_area(cube, diagonal, 1), 0);
}

// A stone between two plates, held bodies, that approach each other.
struct Plates {
  static constexpr double speed = 0.4;  // m/s, of each plate
  par::Comm comm = par::Comm::self();
  dem::Particles particles;
  Plates(const dem::Template& stone, double scale, const dem::BreakageParameters& p)
      : particles(comm, test::one_material(elastic(), density),
                  {.largest_overlap = 1, .gravity = 0},
                  test::box(Vec3::Constant(-0.2), Vec3::Constant(0.2))) {
    particles.set_breakage(p);
    particles.add_template(stone);
    const int plate = particles.add_template(
        geom::template_of({{test::cuboid_core(0.5 * Vec3(0.1, 0.1, 0.02)), 0.005}}));
    std::vector<dem::NewParticle> bodies(3);
    const double up = scale * geom::support_of(stone, Vec3::UnitZ());
    const double down = scale * geom::support_of(stone, -Vec3::UnitZ());
    bodies[0].scale = scale;
    for (std::size_t k : {1U, 2U}) {
      const double side = k == 1 ? 1 : -1;
      bodies[k].id = static_cast<Id>(k), bodies[k].shape = plate, bodies[k].held = true;
      bodies[k].position = Vec3(0, 0, side * 0.015 + (k == 1 ? up : -down));
      bodies[k].velocity = Vec3(0, 0, -side * speed);
    }
    particles.add(bodies);
    particles.set_surfaces({});
    particles.let_break(true);
  }
  void step() {
    particles.advance(8 * dt, 8);
    ASSERT_EQ(particles.trouble(), "");
  }
};

// The mean stress of a cuboid between plates is F/A along their distance, whose octahedral shear
// stress is sqrt(2)/3 F/A.
TEST(Splitting, OfACuboidBeginsAtItsStrength) {
  constexpr double side = 0.03, height = 0.04, rounding = 0.002;
  const geom::Template stone =
      geom::template_of({{test::cuboid_core(0.5 * Vec3(side - 2 * rounding, side - 2 * rounding,
                                                       height - 2 * rounding)),
                          rounding}});
  const dem::BreakageParameters p = weak(10e6);
  Plates plates(stone, 1, p);
  const double diameter = std::cbrt(stone.volume / ball(1));
  const double strength = dem::splitting_strength(p, 0, 0, diameter);
  const double before = plates.particles.totals().mass;
  double elastic = 0;
  for (int k = 0; k < 3000 && plates.particles.broken().splits == 0; ++k) {
    elastic = plates.particles.totals().elastic;
    plates.step();
  }
  ASSERT_EQ(plates.particles.broken().splits, 1);
  const dem::Break& split = plates.particles.breaks().front();
  EXPECT_EQ(split.kind, dem::BreakKind::split);
  // Two checks are 16 sub-steps apart, in which the force grows by 2 k v t.
  const double length = 2 * geom::support_of(stone, Vec3::UnitZ());
  const double area = stone.volume / length,
               growth = elastic > 0 ? 2 * 1e7 * Plates::speed * 16 * dt : 0;
  const double force = strength * area * 3 / std::numbers::sqrt2;
  EXPECT_GE(split.stress, strength);
  // The overlap, 2 % of the height, shortens the arms of the forces.
  EXPECT_NEAR(split.force, force, growth + 0.03 * force);
  // All elastic energy is released, as both parts touch nothing.
  EXPECT_NEAR(split.released, elastic, 0.05 * elastic);
  EXPECT_LT(plates.particles.totals().elastic, 1e-3 * elastic);
  const dem::BreakTotals broken = plates.particles.broken();
  EXPECT_NEAR(plates.particles.totals().mass + broken.fines_mass, before, 1e-13 * before);
  EXPECT_EQ(plates.particles.size(), 4U);
}

// Two cuboids of a third and two thirds of the length, side by side between plates, part at their
// joint; on top of each other they do not, since the joint is compressed.
TEST(Splitting, OfACompoundIsAtItsJointUnlessThisIsCompressedMost) {
  constexpr double rounding = 0.001;
  for (const bool pressed : {false, true}) {
    const auto piece = [&](double from, double to) {
      geom::Convex core = test::cuboid_core(
          0.5 * (pressed ? Vec3(0.03, 0.028, to - from) : Vec3(to - from, 0.03, 0.028)));
      for (Vec3& v : core.vertices) v[pressed ? 2 : 0] += (from + to) / 2;
      return geom::Piece{geom::convex_hull(core.vertices), rounding};
    };
    dem::Template stone;  // with the axes of its edges, about its centre of mass
    stone.pieces = {piece(-0.018, -0.006), piece(-0.006, 0.018)};
    stone.volume = 3.4e-5, stone.gyration = Vec3::Constant(2e-4), stone.sieve = 0.03;
    const auto joints = geom::joints_of(stone);
    ASSERT_EQ(joints.size(), 1U);
    for (const geom::Joint& joint : joints) {
      EXPECT_NEAR(std::abs(joint.normal[pressed ? 2 : 0]), 1, 1e-12);
      EXPECT_NEAR(joint.offset * joint.normal[pressed ? 2 : 0], -0.006, 1e-12);
    }
    Plates plates(stone, 1, weak(10e6));
    for (int k = 0; k < 3000 && plates.particles.broken().splits == 0; ++k) plates.step();
    ASSERT_EQ(plates.particles.broken().splits, 1);
    // A joint leaves each part one of the pieces; any other plane cuts both. Two plates.
    EXPECT_EQ(plates.particles.totals().particles, 4);
    EXPECT_EQ(plates.particles.totals().pieces, pressed ? 6 : 4);
  }
}

TEST(Joints, AreNotThereInOnePieceOrThroughAThird) {
  const geom::Convex core = geom::rounded_stone({.vertices = 16}, 0.05, 7).core;
  EXPECT_TRUE(geom::joints_of(polyhedron(7)).empty());
  for (const int parts : {2, 3, 4}) {
    std::vector<geom::Piece> pieces;
    for (const geom::Convex& slice : geom::sliced(core, parts)) pieces.push_back({slice, 0.05});
    const geom::Template stone = geom::template_of(pieces);
    const auto joints = geom::joints_of(stone);
    EXPECT_GE(joints.size(), 1U) << parts;
    EXPECT_LT(joints.size(), static_cast<std::size_t>(parts)) << parts;
    for (const geom::Joint& joint : joints) {
      const auto below = geom::part_below(stone, joint.normal, joint.offset),
                 above = geom::part_below(stone, -joint.normal, -joint.offset);
      ASSERT_TRUE(below && above);
      EXPECT_EQ(below->stone.pieces.size() + above->stone.pieces.size(), pieces.size());
    }
  }
}

// A corner on a plate is cut until its face bears the force, deeper and deeper.
TEST(Cutting, GivesACornerTheAreaThatItsForceNeeds) {
  geom::Template stone =
      geom::template_of({{test::cuboid_core(0.5 * Vec3::Constant(0.03)), 0.0015}});
  // Principal axes of a cube may have any direction.
  const Vec3 corner = stone.pieces[0].core.vertices[0];
  const Quat onto_corner = Quat::FromTwoVectors(corner, Vec3::UnitZ());
  for (geom::Piece& piece : stone.pieces)
    piece.core = geom::moved(piece.core, onto_corner, Vec3::Zero());
  const dem::BreakageParameters p = weak(0, 30e6);
  Plates plates(stone, 1, p);
  const double before = plates.particles.totals().mass, pressure = dem::cutting_strength(p, 0);
  double released = 0;
  for (int k = 0; k < 3000 && plates.particles.broken().cuts < 6; ++k) plates.step();
  ASSERT_GE(plates.particles.broken().cuts, 6);
  EXPECT_EQ(plates.particles.broken().splits, 0);
  for (const dem::Break& cut : plates.particles.breaks()) {
    EXPECT_EQ(cut.kind, dem::BreakKind::cut);
    EXPECT_EQ(cut.stress, pressure);
    released += cut.released;
  }
  EXPECT_EQ(plates.particles.broken().released, released);
  // The section of a cube's corner at the distance t has the area sqrt(27)/2 t^2.
  const dem::Break& first = plates.particles.breaks().front();
  const double depth = std::sqrt(2 * first.force / (pressure * std::sqrt(27.0)));
  const Vec3 up = Vec3::UnitZ();
  const auto rest = geom::part_below(stone, up, geom::support_of(stone, up) - depth);
  ASSERT_TRUE(rest);
  EXPECT_LT(depth, p.cutting.largest_depth * std::cbrt(stone.volume / ball(1)));
  EXPECT_NEAR(first.mass, density * (stone.volume - rest->stone.volume), 1e-9 * before);
  const dem::BreakTotals broken = plates.particles.broken();
  EXPECT_NEAR(plates.particles.totals().mass + broken.fines_mass, before, 1e-13 * before);
  EXPECT_GT(broken.fines_mass, 0);
}

// Two stones that collide head-on.
struct Collision {
  par::Comm comm = par::Comm::self();
  dem::Particles particles;
  explicit Collision(const dem::BreakageParameters& p, std::uint64_t seed)
      : particles(comm, test::one_material(elastic(), density),
                  {.largest_overlap = 1, .gravity = 0},
                  test::box(Vec3::Constant(-0.5), Vec3::Constant(0.5))) {
    particles.set_breakage(p);
    std::vector<dem::NewParticle> two(2);
    for (std::size_t k : {0U, 1U}) {
      const double side = k == 0 ? -1 : 1;
      particles.add_template(polyhedron(seed + k));
      two[k].id = static_cast<Id>(k), two[k].shape = static_cast<int>(k), two[k].scale = 0.03;
      two[k].position = Vec3(side * 0.025, k == 0 ? 0.002 : 0, 0);
      two[k].velocity = Vec3(-side * 4, 0.3, 0.1);
      two[k].spin = Vec3(5, 3, side * 4);
    }
    particles.add(two);
    particles.set_surfaces({});
    particles.let_break(true);
  }
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < particles.size(); ++i)
      sum += particles[i].mass * particles[i].position.cross(particles[i].velocity) +
             particles[i].angular_momentum;
    return sum;
  }
};

// Mass to rounding; momentum but for that of fines; no energy is created.
TEST(Splitting, BalancesMassMomentumAndEnergy) {
  std::int64_t events = 0;
  for (std::uint64_t seed = 1; seed <= 12; seed += 2)
    for (const auto& p : {weak(2e6), weak(0, 20e6), weak(4e6, 20e6)}) {
      Collision c(p, seed);
      const dem::Totals before = c.particles.totals();
      const Vec3 turning = c.angular_momentum();
      for (int w = 0; w < 400; ++w) {
        c.particles.advance(4 * dt, 4);
        ASSERT_EQ(c.particles.trouble(), "");
      }
      const dem::Totals after = c.particles.totals();
      const dem::BreakTotals broken = c.particles.broken();
      events += broken.splits + broken.cuts;
      EXPECT_NEAR(after.mass + broken.fines_mass, before.mass, 1e-13 * before.mass);
      const double speed = 4.1, fines = broken.fines_mass * speed;
      EXPECT_LT((after.momentum - before.momentum).norm(), fines + 1e-12 * before.mass * speed);
      EXPECT_LT((c.angular_momentum() - turning).norm(), 0.03 * fines + 1e-3 * turning.norm());
      // The margin is that of the integration of the collision.
      EXPECT_LT(after.kinetic + after.elastic, before.kinetic * (1 + 2e-3)) << "seed " << seed;
    }
  EXPECT_GT(events, 20);
}

// A part lighter than the lightest one allowed is removed; a stone of which no part would be heavy
// enough stays whole.
TEST(Splitting, EndsAtTheLeastSize) {
  dem::BreakageParameters p = weak(1e5);
  Collision often(p, 3);
  p.least_size = 0.03;
  Collision never(p, 3);
  for (int w = 0; w < 400; ++w)
    for (Collision* c : {&often, &never}) {
      c->particles.advance(4 * dt, 4);
      ASSERT_EQ(c->particles.trouble(), "");
    }
  EXPECT_GT(often.particles.broken().splits, 5);
  for (std::size_t i = 0; i < often.particles.size(); ++i)
    EXPECT_GE(often.particles[i].mass, density * ball(5e-3));
  EXPECT_EQ(never.particles.broken().splits, 0);
  EXPECT_LT(never.particles[0].mass, density * ball(0.03));
}

// Stones that are launched against each other and on a floor, in a periodic box.
struct Heap {
  Surface floor = test::floor_of(5, 0.7);
  dem::Particles particles;
  explicit Heap(const par::Comm& comm, double skin = 0)
      : particles(comm, test::one_material(elastic(), density),
                  {.skin = skin, .largest_overlap = 1}, domain()) {
    particles.set_breakage(weak(5e5, 40e6));
  }
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.36, 0.36, 0.6});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm) {
    particles.add_template(polyhedron(5));
    particles.add_template(geom::template_of(
        {{geom::sliced(geom::rounded_stone({.vertices = 16}, 0.05, 7).core, 2)[0], 0.05},
         {geom::sliced(geom::rounded_stone({.vertices = 16}, 0.05, 7).core, 2)[1], 0.05}}));
    auto all = test::lattice({6, 6, 2}, 0.06, 0.045, 2);
    for (dem::NewParticle& p : all) p.velocity *= 12;
    particles.add(test::mine(comm, all));
    connect();
    particles.let_break(true);
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int windows, int moves = 0) {
    for (int w = 0; w < windows; ++w) {
      if (moves > 0 && w % moves == moves - 1) particles.repartition();
      particles.advance(8 * dt, 4);
      EXPECT_EQ(particles.trouble(), "");
    }
  }
};

TEST(SplittingRanks, DoNotDependOnListsAndRanks) {
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  Heap shared(world, 2.5e-3), alone(self);
  shared.pour(world), alone.pour(self);
  const double mass = alone.particles.totals().mass;
  shared.run(200, 50), alone.run(200);
  EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
  const dem::BreakTotals one = alone.particles.broken(), all = shared.particles.broken();
  EXPECT_GT(one.splits, 10);
  EXPECT_GT(one.cuts, 10);
  EXPECT_EQ(one.splits, all.splits);
  EXPECT_EQ(one.cuts, all.cuts);
  EXPECT_EQ(one.fragments, all.fragments);
  EXPECT_EQ(one.fines_mass, all.fines_mass);
  EXPECT_EQ(one.released, all.released);
  EXPECT_EQ(one.lost, all.lost);
  EXPECT_NEAR(alone.particles.totals().mass + one.fines_mass, mass, 1e-12 * mass);
}

TEST(SplittingRanks, ContinueFromACheckpoint) {
  const par::Comm world = par::Comm::world();
  const std::string path = "splitting_" + std::to_string(world.size()) + ".h5";
  Heap probe(world), whole(world), second(world);
  probe.pour(world), whole.pour(world);
  int windows = 0;
  for (; windows < 200 && probe.particles.broken().splits < 3; ++windows) probe.run(1);
  whole.run(windows - 1);  // stones that split in the next window are in the checkpoint
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
  EXPECT_GT(then.splits, 0);
  second.run(1), whole.run(1);
  EXPECT_EQ(second.particles.broken().splits, probe.particles.broken().splits);
  EXPECT_GT(probe.particles.broken().splits, then.splits);
  second.run(100), whole.run(100);
  EXPECT_EQ(second.particles.state_hash(), whole.particles.state_hash());
  EXPECT_EQ(second.particles.broken().splits, whole.particles.broken().splits);
  EXPECT_EQ(second.particles.broken().lost, whole.particles.broken().lost);
  EXPECT_GT(whole.particles.broken().splits, then.splits);
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

}  // namespace
}  // namespace trackbed::splitting_test
