// Stones, boxes, compounds and spheres in rough, damped collisions with rolling resistance: bitwise
// identical results on any number of ranks, with any skin, through repartitions and through a
// checkpoint written during contact.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/stone_pairs.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::stones_rank_test {
namespace {

constexpr double dt = 2e-5;  // s, a tenth of sqrt(m/k)
constexpr int windows = 40;

// `hard`: so fast that their cores overlap.
dem::Particles crowd(const par::Comm& comm, double skin, bool hard = false) {
  dem::ContactLaw law;
  law.k_n = 1e6, law.k_s = 0.8e6;
  law.friction = 0.5, law.zeta_n = 0.1, law.zeta_s = 0.1;
  law.rolling_friction = 0.2, law.zeta_r = 0.1;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 10, parameters.skin = skin;
  dem::Domain domain = test::box(Vec3::Zero(), {0.259, 0.222, 0.222});
  domain.periodic = {true, true, true};
  dem::Particles p(comm, test::one_material(law), parameters, domain);
  p.add_template(test::stone(1));
  p.add_template(test::cuboid({0.5, 0.35, 0.3}));
  p.add_template(test::compound(1));
  p.add_template(test::sphere(0.5));
  auto all = test::lattice({7, 6, 6}, 0.037, 0.045, 4);
  for (dem::NewParticle& n : all) n.velocity *= hard ? 80 : 4;
  p.add(test::mine(comm, all));
  return p;
}

struct Outcome {
  std::uint64_t hash;
  dem::Totals totals;
  std::int64_t rebuilds;
};

Outcome run(const par::Comm& comm, double skin = 0, bool shuffle = false) {
  dem::Particles p = crowd(comm, skin);
  for (int w = 0; w < windows; ++w) {
    if (shuffle && w % 7 == 6) p.repartition();
    p.advance(10 * dt, 10);
    EXPECT_EQ(p.trouble(), "");
  }
  return {p.state_hash(), p.totals(), p.rebuilds()};
}

void expect_equal(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.hash, b.hash);
  EXPECT_EQ(a.totals.contacts, b.totals.contacts);
  EXPECT_EQ(a.totals.kinetic, b.totals.kinetic);
  EXPECT_EQ(a.totals.elastic, b.totals.elastic);
  EXPECT_GT(a.totals.contacts, 60);
}

TEST(StoneCrowd, RanksAreBitwiseIdentical) {
  expect_equal(run(par::Comm::world()), run(par::Comm::self()));
}

// The law of overlapping cores uses other paths than that of roundings.
TEST(StoneCrowd, OverlappingCoresAreBitwiseIdentical) {
  const auto fly = [](const par::Comm& comm, std::int64_t* deep) {
    dem::Particles p = crowd(comm, 0, true);
    for (int w = 0; w < windows; ++w) {
      if (w % 7 == 6) p.repartition();
      p.advance(10 * dt, 10);
    }
    *deep = p.core_overlaps();
    return p.state_hash();
  };
  std::int64_t together = 0, alone = 0;
  EXPECT_EQ(fly(par::Comm::world(), &together), fly(par::Comm::self(), &alone));
  EXPECT_EQ(together, alone);
  EXPECT_GT(alone, 100);
}

TEST(StoneCrowd, RepartitionChangesNothing) {
  expect_equal(run(par::Comm::world(), 0, true), run(par::Comm::self()));
}

TEST(StoneCrowd, SkinChangesNothing) {
  const Outcome small = run(par::Comm::world(), 2e-4), large = run(par::Comm::world(), 8e-3);
  expect_equal(small, large);
  EXPECT_GT(small.rebuilds, 3 * large.rebuilds);
}

TEST(StoneCrowd, ACheckpointBetweenChangesNothing) {
  const par::Comm world = par::Comm::world();
  const std::string path = "stones_" + std::to_string(world.size()) + ".h5";
  dem::Particles straight = crowd(world, 0), resumed = crowd(world, 3e-3);
  straight.advance(windows / 2 * 10 * dt, windows / 2 * 10);
  EXPECT_GT(straight.totals().contacts, 60);
  {
    io::File file(world, path, io::Mode::create);
    straight.save(file, "particles");
    file.close();
  }
  {
    const io::File file(world, path, io::Mode::read);
    resumed.load(file, "particles");
  }
  EXPECT_EQ(straight.state_hash(), resumed.state_hash());
  for (int w = 0; w < windows / 2; ++w) straight.advance(10 * dt, 10), resumed.advance(10 * dt, 10);
  EXPECT_EQ(straight.state_hash(), resumed.state_hash());
  EXPECT_EQ(straight.totals().elastic, resumed.totals().elastic);
  if (world.rank() == 0) std::filesystem::remove(path);
}

}  // namespace
}  // namespace trackbed::stones_rank_test
