// The balance of energy: what friction, dashpots and local damping dissipate and surfaces supply is
// what kinetic, potential and elastic energy lack, on any number of ranks and after a restart.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "support/scene.hpp"
#include "support/stone_pairs.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::energy_balance_test {
namespace {

enum class Kind { sphere, clump, stone };

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 1e5, law.k_s = 0.8e5;
  law.friction = 0.4;
  law.zeta_n = 0.1, law.zeta_s = 0.1;
  return law;
}

dem::Physics hertz(double friction) {
  dem::ContactLaw law;
  law.kind = dem::LawKind::hertz;
  law.friction = friction, law.restitution = 0.7;
  dem::Physics physics = test::one_material(law);
  physics.materials[0].young = 3e7;
  return physics;
}

double stored(const dem::Totals& totals) {
  return totals.kinetic + totals.potential + totals.elastic;
}
double dissipated(const dem::Totals& totals) {
  return totals.account->friction + totals.account->contact_damping + totals.account->local_damping;
}
// What the balance lacks between two instants, J.
double error(const dem::Totals& before, const dem::Totals& after) {
  return stored(after) - stored(before) - after.account->supplied + dissipated(after) -
         dissipated(before) + before.account->supplied;
}

dem::Particles space(const dem::Physics& physics, double gravity) {
  return {par::Comm::self(),
          physics,
          {.largest_overlap = 1, .gravity = gravity, .energy_balance = true},
          test::box(Vec3(-1, -1, -0.05), Vec3(1, 1, 1))};
}

void add_ball(dem::Particles& particles, Id id, const Vec3& position, const Vec3& velocity) {
  dem::NewParticle ball;
  ball.id = id, ball.scale = 0.01, ball.position = position, ball.velocity = velocity;
  particles.add(std::vector{ball});
}

TEST(EnergyBalance, IsOptional) {
  dem::Particles particles(par::Comm::self(), test::one_material(rough()), {},
                           test::box(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  particles.add_template(test::sphere());
  add_ball(particles, 0, Vec3::Zero(), Vec3::Zero());
  EXPECT_FALSE(particles.totals().account);
}

// Head on, only dashpots dissipate; the law's trapezoid is exact for the springs.
TEST(EnergyBalance, DashpotsTakeWhatACollisionLoses) {
  for (const bool is_hertz : {false, true}) {
    dem::Particles particles = space(is_hertz ? hertz(0) : test::one_material(rough()), 0);
    particles.add_template(test::sphere());
    add_ball(particles, 0, Vec3(-0.0101, 0, 0), Vec3(0.5, 0, 0));
    add_ball(particles, 1, Vec3(0.0101, 0, 0), Vec3(-0.5, 0, 0));
    particles.set_surfaces({});
    const dem::Totals before = particles.totals();
    particles.advance(0.01, 5000);
    const dem::Totals after = particles.totals();
    const double lost = before.kinetic - after.kinetic;
    EXPECT_EQ(after.contacts, 0);
    EXPECT_GT(lost, 0.2 * before.kinetic);
    // Dampers are half a step late.
    EXPECT_NEAR(after.account->contact_damping, lost, 2e-3 * lost);
    EXPECT_NEAR(after.account->friction, 0, 1e-12 * lost);
  }
}

// Of a block of 0.05 x 0.04 x 0.02 m on a floor, without dashpots, until it rests.
struct Rest {
  dem::Totals before, after;
};
Rest come_to_rest(const Vec3& velocity, const Vec3& spin) {
  dem::ContactLaw law = rough();
  law.k_n = law.k_s = 1e7, law.zeta_n = law.zeta_s = 0;
  dem::Particles particles = space(test::one_material(law), 9.81);
  const dem::Template block =
      geom::template_of({{test::cuboid_core(0.5 * Vec3(0.05, 0.04, 0.02)), 0.002}});
  particles.add_template(block);
  dem::NewParticle one;
  one.position.z() = geom::support_of(block, Vec3::UnitZ());
  one.velocity = velocity, one.spin = spin;
  particles.add(std::vector{one});
  Surface floor = test::floor_of(1, 0.5);
  particles.set_surfaces({&floor});
  const dem::Totals before = particles.totals();
  for (int w = 0; w < 300; ++w) particles.advance(1e-3, 250);
  return {before, particles.totals()};
}

// What is left of the motion is a vibration of the springs on which the block stands. Coulomb's
// limit follows it, so that friction and not the last vibration takes the energy.
constexpr double vibration = 2e-3;  // of the energy

TEST(EnergyBalance, FrictionTakesTheMotionOfASlidingBlock) {
  const auto [before, after] = come_to_rest(Vec3(0.4, 0, 0), Vec3::Zero());
  EXPECT_LT(after.kinetic, 1e-3 * before.kinetic);
  EXPECT_NEAR(after.account->friction, before.kinetic, vibration * before.kinetic);
  EXPECT_NEAR(after.account->contact_damping, 0, vibration * before.kinetic);
  EXPECT_NEAR(error(before, after), 0, vibration * before.kinetic);
}

// About the normal of the contact: torsion.
TEST(EnergyBalance, FrictionTakesTheRotationOfABlock) {
  const auto [before, after] = come_to_rest(Vec3::Zero(), Vec3(0, 0, 20));
  EXPECT_LT(after.kinetic, 1e-3 * before.kinetic);
  EXPECT_NEAR(after.account->friction, before.kinetic, vibration * before.kinetic);
  EXPECT_NEAR(error(before, after), 0, vibration * before.kinetic);
}

// A ball that rolls on a floor, whose sliders of rolling take its motion.
TEST(EnergyBalance, RollingResistanceIsFriction) {
  dem::ContactLaw law = rough();
  law.k_n = law.k_s = 1e6, law.zeta_n = law.zeta_s = law.zeta_r = 0, law.rolling_friction = 0.05;
  dem::Particles particles = space(test::one_material(law), 9.81);
  particles.add_template(test::sphere());
  dem::NewParticle ball;
  ball.scale = 0.01, ball.position = Vec3(0, 0, 0.01);
  ball.velocity = Vec3(0.1, 0, 0), ball.spin = Vec3(0, 10, 0);  // without slip
  particles.add(std::vector{ball});
  Surface floor = test::floor_of(1, 0.5);
  particles.set_surfaces({&floor});
  const dem::Totals before = particles.totals();
  for (int w = 0; w < 300; ++w) particles.advance(1e-3, 100);
  const dem::Totals after = particles.totals();
  EXPECT_LT(after.kinetic, 0.01 * before.kinetic);
  EXPECT_NEAR(after.account->friction, before.kinetic, 0.01 * before.kinetic);
  EXPECT_NEAR(error(before, after), 0, vibration * before.kinetic);
}

// In flight, the impulse of local damping is all that takes energy.
TEST(EnergyBalance, LocalDampingIsExact) {
  dem::Physics physics = test::one_material(rough());
  physics.materials[0].local_damping = 0.6;
  dem::Particles particles = space(physics, 9.81);
  particles.add_template(test::clump());
  add_ball(particles, 0, Vec3(0, 0, 0.5), Vec3(0.3, -0.2, 1.5));
  particles.set_surfaces({});
  const dem::Totals before = particles.totals();
  for (int w = 0; w < 20; ++w) particles.advance(0.01, 100);
  const dem::Totals after = particles.totals();
  EXPECT_GT(after.account->local_damping, 0.1 * before.kinetic);
  EXPECT_NEAR(error(before, after), 0, 1e-12 * stored(before));
}

// Particles that fall on a floor which lifts them, in a box that is periodic along x and y.
struct Heap {
  Surface floor = test::floor_of(7, 0.6);
  dem::Particles particles;
  Heap(const par::Comm& comm, const dem::Physics& physics, double skin = 0, bool accounts = true)
      : particles(comm, physics, {.skin = skin, .largest_overlap = 1, .energy_balance = accounts},
                  domain()) {}
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.24, 0.18, 0.5});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm, Kind kind) {
    if (kind == Kind::sphere) particles.add_template(test::sphere());
    if (kind == Kind::clump) particles.add_template(test::clump());
    if (kind == Kind::stone)
      particles.add_template(geom::template_of({geom::rounded_stone({.vertices = 12}, 0.1, 3)}));
    const double radius = kind == Kind::stone ? 0.02 : 0.01;
    particles.add(test::mine(comm, test::lattice({8, 6, 3}, 0.03, radius, 1)));
    connect();
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int windows, int steps, int moves = 0) {
    constexpr double window = 1e-3, lift = 0.02;  // s, m/s
    for (int w = 0; w < windows; ++w) {
      if (moves > 0 && w % moves == moves - 1) particles.repartition();
      floor.motion.assign(floor.nodes(), Vec3(0, 0, lift * window));
      particles.advance(window, steps);
      for (Vec3& x : floor.position) x.z() += lift * window;
      floor.clear_load();
      EXPECT_EQ(particles.trouble(), "");
    }
  }
};

dem::Physics heap_law(bool is_hertz, bool rolls) {
  dem::Physics physics = is_hertz ? hertz(0.4) : test::one_material(rough());
  physics.materials[0].local_damping = 0.2;
  if (rolls) physics.laws[0].rolling_friction = 0.1, physics.laws[0].zeta_r = 0.1;
  return physics;
}

constexpr int windows = 100;
int steps_of(Kind kind) { return kind == Kind::stone ? 80 : 40; }  // of a window

class EnergyBalanceRanks : public testing::TestWithParam<std::tuple<Kind, bool, bool>> {};

TEST_P(EnergyBalanceRanks, DoesNotDependOnListsAndRanks) {
  const auto [kind, is_hertz, rolls] = GetParam();
  const par::Comm world = par::Comm::world(), self = par::Comm::self();
  const dem::Physics physics = heap_law(is_hertz, rolls);
  Heap shared(world, physics, 4e-3), alone(self, physics), silent(self, physics, 0, false);
  shared.pour(world, kind), alone.pour(self, kind), silent.pour(self, kind);
  const dem::Totals before = alone.particles.totals();
  const int steps = steps_of(kind);
  shared.run(windows, steps, 40), alone.run(windows, steps), silent.run(windows, steps);
  EXPECT_EQ(silent.particles.state_hash(), alone.particles.state_hash());
  EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
  const dem::Totals one = alone.particles.totals(), all = shared.particles.totals();
  EXPECT_EQ(one.account->friction, all.account->friction);
  EXPECT_EQ(one.account->contact_damping, all.account->contact_damping);
  EXPECT_EQ(one.account->local_damping, all.account->local_damping);
  EXPECT_EQ(one.account->supplied, all.account->supplied);
  EXPECT_GT(one.account->friction, 0.05 * before.kinetic);
  EXPECT_GT(one.account->contact_damping, 0.05 * before.kinetic);
  EXPECT_GT(one.account->local_damping, 0.05 * before.kinetic);
  EXPECT_GT(one.account->supplied, 0.01 * before.kinetic);
}

// Dampers are half a step late, so the error is of first order: 0.1 to 2 per cent of what is
// dissipated, and 0.42 to 0.49 times that with half the step.
TEST_P(EnergyBalanceRanks, ClosesWithTheStep) {
  if (par::Comm::world().size() > 1) GTEST_SKIP() << "the same on each rank";
  const auto [kind, is_hertz, rolls] = GetParam();
  const par::Comm self = par::Comm::self();
  const auto part_missing = [&](int steps) {
    Heap heap(self, heap_law(is_hertz, rolls));
    heap.pour(self, kind);
    const dem::Totals before = heap.particles.totals();
    heap.run(windows, steps);
    const dem::Totals after = heap.particles.totals();
    return error(before, after) / dissipated(after);
  };
  const double coarse = part_missing(steps_of(kind)), fine = part_missing(2 * steps_of(kind));
  EXPECT_LT(std::abs(coarse), 0.025);
  EXPECT_NEAR(fine / coarse, 0.46, 0.08);
}

INSTANTIATE_TEST_SUITE_P(
    Heaps, EnergyBalanceRanks,
    testing::Values(std::tuple{Kind::sphere, false, false}, std::tuple{Kind::sphere, true, true},
                    std::tuple{Kind::clump, false, true}, std::tuple{Kind::clump, true, false},
                    std::tuple{Kind::stone, false, false}, std::tuple{Kind::stone, true, true}));

// Accounts of particles that were removed are kept, and all continue from a checkpoint.
TEST(EnergyAccounts, AreKept) {
  const par::Comm world = par::Comm::world();
  const std::string path = "accounts_" + std::to_string(world.size()) + ".h5";
  const dem::Physics physics = heap_law(false, false);
  Heap whole(world, physics), second(world, physics);
  whole.pour(world, Kind::sphere);
  whole.run(60, steps_of(Kind::sphere));
  const dem::EnergyAccount before = *whole.particles.totals().account;
  EXPECT_GT(whole.particles.remove([](const dem::ParticleView& p) { return p.id % 3 == 0; }), 0);
  const dem::EnergyAccount after = *whole.particles.totals().account;
  EXPECT_NEAR(after.friction, before.friction, 1e-12 * before.friction);
  EXPECT_NEAR(after.contact_damping, before.contact_damping, 1e-12 * before.contact_damping);
  EXPECT_NEAR(after.local_damping, before.local_damping, 1e-12 * before.local_damping);
  EXPECT_NEAR(after.supplied, before.supplied, 1e-12 * before.supplied);
  {
    io::File file(world, path, io::Mode::create);
    whole.particles.save(file, "p");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.particles.load(file, "p");
  }
  second.floor.position = whole.floor.position;
  second.connect();
  whole.run(30, steps_of(Kind::sphere)), second.run(30, steps_of(Kind::sphere));
  const dem::EnergyAccount one = *whole.particles.totals().account;
  const dem::EnergyAccount other = *second.particles.totals().account;
  EXPECT_GT(one.friction, after.friction);
  EXPECT_EQ(one.friction, other.friction);
  EXPECT_EQ(one.contact_damping, other.contact_damping);
  EXPECT_EQ(one.local_damping, other.local_damping);
  EXPECT_EQ(one.supplied, other.supplied);
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

// Without an account for the first run, it begins at zero in the second.
TEST(EnergyAccounts, AreEmptyWithoutTheOption) {
  const par::Comm world = par::Comm::world();
  const std::string path = "silent_" + std::to_string(world.size()) + ".h5";
  const dem::Physics physics = heap_law(false, false);
  Heap silent(world, physics, 0, false), second(world, physics);
  silent.pour(world, Kind::stone);
  silent.run(60, steps_of(Kind::stone));
  {
    io::File file(world, path, io::Mode::create);
    silent.particles.save(file, "p");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.particles.load(file, "p");
  }
  const dem::EnergyAccount account = *second.particles.totals().account;
  EXPECT_EQ(account.friction, 0);
  EXPECT_EQ(account.contact_damping, 0);
  EXPECT_EQ(account.local_damping, 0);
  EXPECT_EQ(account.supplied, 0);
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

// Two bonded balls in motion relative to each other.
struct BondedPair {
  dem::Particles particles = space(test::one_material(rough()), 0);
  dem::Totals before;
  BondedPair(const Vec3& velocity, const dem::BondParameters& glue) {
    particles.add_template(test::sphere());
    add_ball(particles, 0, Vec3(-0.01, 0, 0), velocity);
    add_ball(particles, 1, Vec3(0.01, 0, 0), -velocity);
    particles.set_bonds({glue});
    particles.set_surfaces({});
    particles.make_lists();
    EXPECT_EQ(particles.bond(0), 1);
    before = particles.totals();
  }
};

TEST(EnergyAccounts, HaveTheDampersOfBonds) {
  dem::BondParameters glue;
  glue.young = 1e8, glue.tension = glue.shear = 1e9, glue.gap = 1e-4, glue.damping = 0.1;
  BondedPair pair(Vec3(0.1, 0, 0.05), glue);
  for (int w = 0; w < 10; ++w) pair.particles.advance(2e-4, 400);
  const dem::Totals after = pair.particles.totals();
  EXPECT_GT(after.account->contact_damping, 0.1 * pair.before.kinetic);
  // Of first order in the step: dampers are half a step late.
  EXPECT_NEAR(error(pair.before, after), 0, 5e-3 * dissipated(after));
}

// Damage takes all that a softening bond costs, not only the rest when it breaks.
TEST(EnergyAccounts, BondsReleaseWhatDamageTakes) {
  dem::BondParameters glue;
  glue.young = 1e7, glue.tension = 1e4, glue.shear = 1e9, glue.gap = 1e-4, glue.softening = 3;
  BondedPair pair(Vec3(-0.2, 0, 0), glue);
  pair.particles.advance(1e-4, 1000);
  const double half = pair.particles.bonded().released;  // softened, but whole
  EXPECT_EQ(pair.particles.bonded().whole, 1);
  EXPECT_GT(half, 0);
  for (int w = 0; w < 20; ++w) pair.particles.advance(1e-4, 1000);
  const dem::Totals after = pair.particles.totals();
  const dem::BondTotals bonds = pair.particles.bonded();
  EXPECT_EQ(bonds.by_tension, 1);
  EXPECT_GT(bonds.released, 1.2 * half);
  // The damage of a step is that of the deformation before: of first order in the step.
  EXPECT_NEAR(pair.before.kinetic - after.kinetic, bonds.released, 5e-3 * bonds.released);
}

}  // namespace
}  // namespace trackbed::energy_balance_test
