// The partition over ranks: it may change at any time and by any weights without affecting results
// or losing particles, it follows the work, and it includes particles of very different size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "dem/search/grid.hpp"
#include "support/scene.hpp"
#include "trackbed/geom/stone.hpp"
#include "trackbed/par/partition.hpp"

namespace trackbed::balance_test {
namespace {

constexpr double dt = 2e-5;  // s, well below sqrt(m/k) of the scenes

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 1e5, law.k_s = 0.8e5;
  law.friction = 0.5;
  law.zeta_n = 0.7, law.zeta_s = 0.3;
  return law;
}

constexpr std::int64_t many = 1000000;  // particles, so that their number does not limit the grid

// A skewed block with rounded edges, of about unit size.
dem::Template stone() {
  const std::vector<Vec3> corners{{-0.7, -0.4, -0.4}, {0.6, -0.5, -0.3}, {0.5, 0.5, -0.4},
                                  {-0.6, 0.4, -0.3},  {-0.5, -0.3, 0.4}, {0.6, -0.4, 0.3},
                                  {0.4, 0.4, 0.5},    {-0.6, 0.3, 0.3}};
  return geom::template_of({{geom::convex_hull(corners), 0.2}});
}

// Stones, clumps and spheres, some of them several times as large, fall on a floor.
struct Heap {
  Surface floor = test::floor_of(9, 0.6);
  dem::Particles particles;

  explicit Heap(const par::Comm& comm, double rebalance = 0)
      : particles(comm, test::one_material(rough()), {.rebalance = rebalance, .largest_overlap = 2},
                  domain()) {
    particles.add_template(stone());
    particles.add_template(test::clump());
    particles.add_template(test::sphere());
    auto all = test::lattice({9, 6, 2}, 0.03, 0.01, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      dem::NewParticle large = all[k];
      large.id = static_cast<Id>(1000 * k);  // before, among and after the others
      large.scale = 0.04, large.position = Vec3(0.05 + 0.1 * static_cast<double>(k), 0.09, 0.12);
      if (k == 0) all[0].id = 999;
      all.push_back(large);
    }
    for (auto& p : all) p.velocity.x() += 0.3, p.velocity.z() -= 1;
    particles.add(test::mine(comm, all));
    particles.set_surfaces({&floor});
  }
  static dem::Domain domain() {
    dem::Domain domain = test::box({0, 0, -0.05}, {0.36, 0.36, 0.5});
    domain.periodic = {true, true, false};
    return domain;
  }
  void run(int windows) {
    for (int k = 0; k < windows; ++k) particles.advance(50 * dt, 50);
    EXPECT_EQ(particles.trouble(), "");
  }
  // Keys and history of every contact, sorted.
  std::vector<std::array<double, 6>> records(const par::Comm& comm) const {
    const std::string path = "balance_" + std::to_string(comm.size()) + ".h5";
    {
      io::File file{comm, path, io::Mode::create};
      particles.save(file, "dem");
    }
    const io::File file{comm, path, io::Mode::read};
    const auto keys = file.read_all<std::int64_t>("dem/history/keys");
    const auto xi = file.read_all<double>("dem/history/xi");
    std::vector<std::array<double, 6>> all;
    for (std::size_t k = 0; 2 * k < keys.size(); ++k)
      all.push_back({static_cast<double>(keys[2 * k]), static_cast<double>(keys[2 * k + 1]),
                     xi[4 * k], xi[4 * k + 1], xi[4 * k + 2], xi[4 * k + 3]});
    std::sort(all.begin(), all.end());
    return all;
  }
};

double chance(const dem::ParticleView& p, std::uint64_t round) {
  const double u = uniform(round, static_cast<std::uint64_t>(p.id));
  return 1e4 * u * u * u * u;
}

TEST(Balance, RandomSplitsLoseNothingAndChangeNoBit) {
  const par::Comm world = par::Comm::world();
  Heap kept(par::Comm::self()), moved(world);
  for (std::uint64_t round = 0; round < 5; ++round) {
    kept.run(24), moved.run(24);
    const auto before = moved.records(world);
    const dem::Totals had = moved.particles.totals();
    const std::uint64_t hash = moved.particles.state_hash();
    EXPECT_EQ(hash, kept.particles.state_hash());
    moved.particles.repartition([&](const auto& p) { return chance(p, round); });
    EXPECT_EQ(moved.records(world), before);
    moved.particles.advance(0, 0);  // new lists only
    EXPECT_EQ(moved.records(world), before);
    EXPECT_EQ(moved.particles.state_hash(), hash);
    const dem::Totals has = moved.particles.totals();
    EXPECT_EQ(has.particles, had.particles);
    EXPECT_EQ(has.mass, had.mass);
    EXPECT_EQ(has.momentum, had.momentum);
  }
  EXPECT_GT(moved.records(world).size(), 50);
}

TEST(Balance, RebalancingChangesNoBit) {
  const par::Comm world = par::Comm::world();
  Heap kept(par::Comm::self()), moved(world, 1.01);
  for (int k = 0; k < 10; ++k) {
    kept.run(6), moved.run(6);
    // An uneven partition, so that there is something to improve.
    moved.particles.repartition([](const auto& p) { return p.position.x() < 0.1 ? 1e4 : 1; });
    moved.particles.advance(0, 0);
    const double uneven = moved.particles.imbalance();
    if (moved.particles.rebalance()) {
      moved.particles.advance(0, 0);
      EXPECT_LT(moved.particles.imbalance(), uneven);
      EXPECT_EQ(moved.particles.balance().before, uneven);
    }
  }
  EXPECT_EQ(moved.particles.state_hash(), kept.particles.state_hash());
  if (world.size() > 1) {
    EXPECT_GE(moved.particles.balance().rebalances, 5);
  }
}

TEST(Balance, ZeroMeansNever) {
  Heap heap(par::Comm::world(), 0);
  heap.run(1);
  heap.particles.repartition([](const auto& p) { return p.position.x() < 0.1 ? 1e4 : 1; });
  heap.particles.advance(0, 0);
  EXPECT_FALSE(heap.particles.rebalance());
}

TEST(Balance, MoreRanksThanParticles) {
  const auto run = [](const par::Comm& comm) {
    dem::Particles particles(comm, test::one_material(rough()), {},
                             test::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}));
    particles.add_template(test::sphere());
    auto two = test::lattice({2, 1, 1}, 0.019, 0.01, 1);
    particles.add(test::mine(comm, two));
    Surface floor = test::floor_of(2, 0.2);
    particles.set_surfaces({&floor});
    for (int k = 0; k < 10; ++k) {
      particles.advance(20 * dt, 20);
      particles.repartition();
    }
    EXPECT_EQ(particles.trouble(), "");
    EXPECT_EQ(particles.totals().particles, 2);
    return particles.state_hash();
  };
  EXPECT_EQ(run(par::Comm::world()), run(par::Comm::self()));
}

// All pairs of spheres in contact, nearest images.
std::set<std::pair<Id, Id>> brute_force(const std::vector<dem::NewParticle>& all,
                                        const dem::Domain& domain) {
  std::set<std::pair<Id, Id>> pairs;
  for (const auto& a : all)
    for (const auto& b : all) {
      Vec3 d = b.position - a.position;
      for (int x = 0; x < 2; ++x) {
        const double period = domain.high[x] - domain.low[x];
        d[x] -= period * std::round(d[x] / period);
      }
      if (a.id < b.id && d.norm() < a.scale + b.scale) pairs.insert({a.id, b.id});
    }
  return pairs;
}

TEST(Sizes, ContactsOfLargeAndSmallAreThoseOfBruteForce) {
  const par::Comm world = par::Comm::world();
  dem::Domain domain = test::box({0, 0, 0}, {0.3, 0.24, 0.2});
  domain.periodic = {true, true, false};
  std::vector<dem::NewParticle> all;
  for (std::uint64_t k = 0; k < 1500; ++k) {
    dem::NewParticle p;
    p.id = static_cast<Id>((k * 7919) % 1500);
    const double u = uniform(1, k);
    p.scale = k < 6 ? 0.03 : k < 30 ? 0.012 : 0.002 + 0.003 * u;  // m; large ones of any id
    p.position = Vec3(0.3 * uniform(2, k), 0.24 * uniform(3, k), 0.2 * uniform(4, k));
    if (k % 3 == 0) p.position.x() += 0.6;  // two periods further
    all.push_back(p);
  }
  dem::Particles particles(world, test::one_material(rough()), {.largest_overlap = 1e9}, domain);
  particles.add_template(test::sphere());
  particles.add(test::mine(world, all));
  particles.advance(1e-12, 1);
  std::vector<Id> mine;
  particles.contacts([&](const dem::ContactView& c) {
    mine.insert(mine.end(), {c.first, c.second});
  });
  const std::vector<Id> found = world.all_gather(std::span<const Id>(mine));
  std::set<std::pair<Id, Id>> pairs;
  for (std::size_t k = 0; k < found.size(); k += 2) pairs.insert({found[k], found[k + 1]});
  EXPECT_EQ(pairs.size(), found.size() / 2);  // each once
  EXPECT_EQ(pairs, brute_force(all, domain));
  EXPECT_GT(pairs.size(), 200);
}

TEST(Split, AThinBedIsCutAcrossItsLength) {
  const double bound[] = {0.01};
  const dem::Domain domain = test::box({0, 0, 0}, {4, 0.2, 0.2});
  dem::Grid grid(domain, bound, 0.002, many);
  const double worst = grid.partition(std::vector<double>(grid.cells(), 1), 4);
  EXPECT_LT(worst, 1.1);
  EXPECT_EQ(worst, grid.worst(std::vector<double>(grid.cells(), 1), 4));
  for (int k = 0; k < 4; ++k) {
    const double x = k + 0.5;
    const int owner = grid.owner_at({x, 0.1, 0.1});
    for (const double y : {0.01, 0.19})
      for (const double z : {0.01, 0.19}) EXPECT_EQ(grid.owner_at({x, y, z}), owner);
  }
}

TEST(Split, FollowsRandomWork) {
  const double bound[] = {0.01};
  dem::Grid grid(test::box({0, 0, 0}, {0.5, 0.4, 0.3}), bound, 0.002, many);
  for (const int ranks : {2, 3, 5, 8}) {
    std::vector<double> work(grid.cells());
    double sum = 0;
    for (std::size_t c = 0; c < work.size(); ++c) {
      work[c] = uniform(static_cast<std::uint64_t>(ranks), c) < 0.5 ? 0 : c % 17 * 1.0;
      sum += work[c];
    }
    grid.partition(work, ranks);
    std::vector<double> of_rank(static_cast<std::size_t>(ranks), 0);
    dem::Lattice cells = grid.levels()[0].lattice;
    for (std::size_t c = 0; c < work.size(); ++c) {
      const int owner = grid.owner_at(cells.centre(c));
      ASSERT_GE(owner, 0);
      ASSERT_LT(owner, ranks);
      of_rank[static_cast<std::size_t>(owner)] += work[c];
    }
    EXPECT_LT(*std::max_element(of_rank.begin(), of_rank.end()), 1.1 * sum / ranks);
  }
}

TEST(Split, AGraphWithFewerVerticesThanPartsIsLeftToBisection) {
  par::Graph graph;
  graph.begin = {0, 0}, graph.weights = {1};
  EXPECT_TRUE(par::partition_graph(graph, 3).empty());
  const double bound[] = {0.05};
  dem::Grid grid(test::box({0, 0, 0}, {0.1, 0.1, 0.1}), bound, 0.0, many);
  EXPECT_EQ(grid.partition({1.0}, 3), 3.0);  // one rank does all the work
}

// A partition made on one rank is the one that as many ranks have, and so is its work but for small
// ghosts beside large stones.
TEST(Decomposition, IsThatOfAsManyRanks) {
  const par::Comm world = par::Comm::world();
  Heap alone(par::Comm::self()), together(world);
  alone.run(3), together.run(3);
  alone.particles.make_lists();
  const dem::Decomposition planned = alone.particles.decomposition(world.size());
  together.particles.repartition();
  together.particles.make_lists();
  const auto own = static_cast<double>(together.particles.size());
  EXPECT_EQ(world.max(own), planned.particles_most);
  EXPECT_EQ(world.sum(own), planned.particles_mean * world.size());
  EXPECT_NEAR(together.particles.imbalance(), planned.work_most / planned.work_mean, 0.05);
  EXPECT_EQ(planned.ghosts_mean > 0, world.size() > 1);
  EXPECT_EQ(planned.neighbours_most > 0, world.size() > 1);
  EXPECT_LE(planned.neighbours_most, world.size() - 1);
}

// Balls in a row of cells: a part receives those within reach beyond its ends.
TEST(Decomposition, CountsGhostsOfARow) {
  dem::Particles particles(par::Comm::self(), test::one_material(rough()), {.skin = 0.002},
                           test::box({0, 0, 0}, {2, 0.1, 0.1}));
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> row;
  for (int k = 0; k < 40; ++k)
    row.push_back({.id = k, .scale = 0.02, .position = {0.025 + 0.05 * k, 0.05, 0.05}});
  particles.add(row);
  particles.make_lists();
  const dem::Decomposition two = particles.decomposition(2);
  EXPECT_EQ(two.particles_mean, 20);
  EXPECT_EQ(two.neighbours_most, 1);
  EXPECT_GE(two.ghosts_mean, 0.5);  // the cut may be anywhere between two balls
  EXPECT_LE(two.ghosts_most, 1);
  EXPECT_EQ(two.bytes_mean / two.ghosts_mean, std::round(two.bytes_mean / two.ghosts_mean));
  const dem::Decomposition one = particles.decomposition(1);
  EXPECT_EQ(one.ghosts_most, 0);
  EXPECT_EQ(one.particles_most, 40);
  EXPECT_LT(two.work_most, one.work_most);
}

}  // namespace
}  // namespace trackbed::balance_test
