// Bitwise identical results on any number of ranks: each scene is run on all ranks together and on
// every rank alone, and the hashes of the states are compared.
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace trackbed::particles_rank_test {
namespace {

constexpr double dt = 5e-5;  // s, well below sqrt(m/k) of the scenes, 3e-4 s

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 1e5, law.k_s = 0.8e5;
  law.friction = 0.5;
  law.zeta_n = 0.2, law.zeta_s = 0.1;
  return law;
}

struct Outcome {
  std::uint64_t hash;
  dem::Totals totals;
};

Outcome pour(const par::Comm& comm, bool clumps, bool periodic, bool shuffle, double mu_r = 0) {
  const double r = 0.01;
  dem::Domain domain = test::box({0, 0, -0.05}, {0.36, 0.18, 0.5});
  if (!periodic) domain.low = {-0.5, -0.5, -0.05}, domain.high = {0.9, 0.7, 0.5};
  domain.periodic = {periodic, periodic, false};
  dem::ContactLaw law = rough();
  law.rolling_friction = mu_r, law.zeta_r = 0.1;
  dem::Particles particles(comm, test::one_material(law), {}, domain);
  particles.add_template(clumps ? test::clump() : test::sphere());
  if (clumps) particles.add_template(test::sphere(0.7));
  particles.add(test::mine(comm, test::lattice({12, 6, 4}, 0.03, r, clumps ? 2 : 1)));
  Surface floor = test::floor_of(7, 0.6);
  particles.set_surfaces({&floor});
  for (int window = 0; window < 104; ++window) {
    if (shuffle && window % 20 == 19) particles.repartition();
    particles.advance(40 * dt, 40);
    EXPECT_EQ(particles.trouble(), "");
  }
  return {particles.state_hash(), particles.totals()};
}

void expect_equal(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.hash, b.hash);
  EXPECT_EQ(a.totals.contacts, b.totals.contacts);
  EXPECT_EQ(a.totals.kinetic, b.totals.kinetic);
  EXPECT_EQ(a.totals.elastic, b.totals.elastic);
  EXPECT_EQ(a.totals.surface_force.z(), b.totals.surface_force.z());
  EXPECT_GT(a.totals.contacts, 50);  // they have touched the floor and each other
}

TEST(Ranks, SpheresAreBitwiseIdentical) {
  expect_equal(pour(par::Comm::world(), false, false, false),
               pour(par::Comm::self(), false, false, false));
}

TEST(Ranks, ClumpsInAPeriodicBoxAreBitwiseIdentical) {
  expect_equal(pour(par::Comm::world(), true, true, false),
               pour(par::Comm::self(), true, true, false));
}

TEST(Ranks, SpheresWithRollingResistanceAreBitwiseIdentical) {
  const Outcome rolling = pour(par::Comm::world(), false, true, true, 0.2);
  expect_equal(rolling, pour(par::Comm::self(), false, true, false, 0.2));
  EXPECT_NE(rolling.hash, pour(par::Comm::world(), false, true, false).hash);
}

TEST(Ranks, RepartitionChangesNothing) {
  const Outcome kept = pour(par::Comm::world(), true, true, false, 0.2);
  const Outcome moved = pour(par::Comm::world(), true, true, true, 0.2);
  expect_equal(kept, moved);
}

TEST(Ranks, NodeLoadsAreExact) {
  // Loads on a floor's nodes, summed over ranks, are bitwise identical to those of one rank.
  const auto loads = [](const par::Comm& comm) {
    dem::Particles particles(comm, test::one_material(rough()), {},
                             test::box({-0.3, -0.3, -0.05}, {0.3, 0.3, 0.5}));
    particles.add_template(test::sphere());
    auto all = test::lattice({10, 10, 2}, 0.03, 0.01, 1);
    for (auto& p : all) p.position -= Vec3(0.15, 0.15, 0.008);
    particles.add(test::mine(comm, all));
    Surface floor = test::floor_of(5, 0.3);
    particles.set_surfaces({&floor});
    particles.advance(160 * dt, 160);
    std::vector<std::int64_t> numbers;
    for (const NodeLoad& load : floor.load) {
      numbers.insert(numbers.end(), load.force.begin(), load.force.end());
      numbers.insert(numbers.end(), load.first.begin(), load.first.end());
    }
    comm.sum(numbers);
    return numbers;
  };
  const auto together = loads(par::Comm::world());
  EXPECT_EQ(together, loads(par::Comm::self()));
  EXPECT_NE(together, std::vector<std::int64_t>(together.size(), 0));
}

}  // namespace
}  // namespace trackbed::particles_rank_test
