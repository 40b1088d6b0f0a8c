// Stones on surfaces: bitwise identical results on any number of ranks, for any time of rebuild,
// after a restart.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/stones.hpp"

namespace trackbed::stones_surface_rank_test {
namespace {

constexpr double dt = 2e-5;  // s

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 5e5, law.k_s = 4e5;
  law.friction = 0.5;
  law.zeta_n = law.zeta_s = 0.5;
  law.rolling_friction = 0.1, law.zeta_r = 0.5;
  return law;
}

// Stones that fall on a floor with a block on it.
struct Heap {
  Surface floor = test::floor_of(11, 0.4);
  Surface block = test::block_of({0.02, 0.2, 0.02}, 3);
  dem::Particles particles;

  Heap(const par::Comm& comm, double skin, bool filled)
      : particles(comm, test::one_material(rough()), {.skin = skin, .largest_overlap = 1},
                  test::box({-0.3, -0.3, -0.05}, {0.3, 0.3, 0.4})) {
    if (filled) {
      particles.add_template(test::irregular(0.016, 0.0015, 1));
      particles.add_template(test::brick({0.015, 0.012, 0.009}, 0.0015));
      auto all = test::lattice({4, 3, 2}, 0.045, 1, 2);
      for (auto& p : all) {
        p.position -= Vec3(0.09, 0.0675, 0);
        p.position.z() += 0.022;
      }
      particles.add(test::mine(comm, all));
      connect();
    }
  }
  void connect() { particles.set_surfaces({&floor, &block}); }
  void run(int windows) {
    for (int k = 0; k < windows; ++k) particles.advance(50 * dt, 50);
    EXPECT_EQ(particles.trouble(), "");
  }
};

std::uint64_t hash_after(const par::Comm& comm, double skin) {
  Heap heap(comm, skin, true);
  heap.run(400);
  EXPECT_GT(heap.particles.totals().contacts, 10);
  return heap.particles.state_hash();
}

TEST(StoneSurfaceRanks, AreBitwiseIdentical) {
  const std::uint64_t together = hash_after(par::Comm::world(), 0);
  EXPECT_EQ(together, hash_after(par::Comm::self(), 0));
  EXPECT_EQ(together, hash_after(par::Comm::world(), 0.012));  // m, rebuilds at other times
}

// A wedge of ground that is higher at one end, periodic along it: a stone that crosses the side
// lands on the other end, whenever lists were made. Stones have a speed along x.
std::uint64_t crossing(const par::Comm& comm, double skin) {
  dem::Domain domain = test::box({-0.3, -0.3, -0.05}, {0.3, 0.3, 0.4});
  domain.periodic = {true, false, false};
  Surface wedge = test::floor_of(22, 0.4);
  for (Vec3& node : wedge.position) node.z() = 0.02 * node.x();
  dem::Particles particles(comm, test::one_material(rough()), {.skin = skin, .largest_overlap = 1},
                           domain);
  particles.add_template(test::irregular(0.016, 0.0015, 1));
  particles.add_template(test::sphere(0.012));
  auto all = test::lattice({6, 3, 1}, 0.09, 1, 2);
  for (auto& p : all) {
    p.position += Vec3(-0.27, -0.13, -0.02);
    p.velocity = Vec3(1, 0, 0);
  }
  particles.add(test::mine(comm, all));
  particles.set_surfaces({&wedge});
  double furthest = 0;
  for (int k = 0; k < 200; ++k) particles.advance(50 * dt, 50);
  EXPECT_EQ(particles.trouble(), "");
  for (std::size_t b = 0; b < particles.size(); ++b)
    furthest = std::max(furthest, particles[b].position.x());
  EXPECT_GT(comm.max(furthest), 0.35);  // they have crossed
  EXPECT_GT(particles.totals().contacts, 5);
  return particles.state_hash();
}

TEST(StoneSurfaceRanks, CrossingAPeriodicSideIsBitwiseIdenticalAtAnyTimeOfRebuild) {
  const std::uint64_t alone = crossing(par::Comm::self(), 0);
  EXPECT_EQ(alone, crossing(par::Comm::world(), 0));
  EXPECT_EQ(alone, crossing(par::Comm::world(), 0.012));
  EXPECT_EQ(alone, crossing(par::Comm::world(), 2e-4));
}

TEST(StoneSurfaceRanks, ARestartIsBitwiseIdentical) {
  const par::Comm world = par::Comm::world();
  const std::string path = "stones_surface_" + std::to_string(world.size()) + ".h5";
  Heap whole(world, 0, true);
  whole.run(80);
  {
    io::File file(world, path, io::Mode::create);
    whole.particles.save(file, "/dem");
  }
  whole.run(30);
  Heap resumed(world, 0, false);
  resumed.particles.load(io::File(world, path, io::Mode::read), "/dem");
  resumed.connect();
  resumed.run(30);
  EXPECT_EQ(whole.particles.state_hash(), resumed.particles.state_hash());
  world.barrier();
  if (world.rank() == 0) std::filesystem::remove(path);
}

}  // namespace
}  // namespace trackbed::stones_surface_rank_test
