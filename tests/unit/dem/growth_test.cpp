// Growth of particles in place: results do not depend on ranks, on the frequency of rebuilds, or on
// a restart; in the end the particles have the specified size.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/stones.hpp"

namespace trackbed::growth_test {
namespace {

constexpr double dt = 2e-5;         // s
constexpr double begin_size = 0.5;  // fraction
constexpr int windows = 200, substeps = 4;
constexpr Id grows_from = 1;  // the first one has a constant size

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 5e5, law.k_s = 4e5;
  law.friction = 0.3;
  law.zeta_n = law.zeta_s = 0.3;
  return law;
}

// Pebbles and stones with corners on a floor, in a box that is periodic along x and y; heavy enough
// to be in contact within the short time of growth.
struct Bed {
  Surface floor = test::floor_of(3, 2);
  dem::Particles particles;

  Bed(const par::Comm& comm, double skin)
      : particles(comm, test::one_material(rough()),
                  {.skin = skin, .largest_overlap = 2, .gravity = 300}, domain()) {}
  static dem::Domain domain() {
    dem::Domain d = test::box({0, 0, -0.05}, {0.18, 0.18, 0.8});
    d.periodic = {true, true, false};
    return d;
  }
  void pour(const par::Comm& comm) {
    particles.add_template(test::irregular(0.022, 0.002, 1));
    particles.add_template(test::brick({0.02, 0.015, 0.012}, 0.002));
    dem::Template pair = test::sphere();
    pair.pieces = {geom::ball({-0.008, 0, 0}, 0.012), geom::ball({0.008, 0, 0}, 0.012)};
    pair.volume = 1.2e-5, pair.gyration = Vec3(6e-5, 1.2e-4, 1.2e-4);
    particles.add_template(pair);
    auto all = test::lattice({6, 6, 4}, 0.03, 1, 3);
    particles.grow_from(grows_from, begin_size);
    particles.add(test::mine(comm, all));
    connect();
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int begin, int end) {
    for (int w = begin; w < end; ++w) {
      const double left = 1 - static_cast<double>(w + 1) / windows;
      if (w < windows) particles.grow_to(1 - (1 - begin_size) * left * left);
      particles.advance(substeps * dt, substeps);
      EXPECT_EQ(particles.trouble(), "");
    }
  }
};

class Growth : public testing::Test {
 protected:
  static constexpr double skin = 5e-3;  // m: lists last for many windows
  par::Comm world = par::Comm::world(), self = par::Comm::self();
};

TEST_F(Growth, IsBitwiseIdenticalOnAnyRanksAndWithAnyLists) {
  Bed shared(world, skin), alone(self, skin), fresh(self, 1e-5);
  shared.pour(world), alone.pour(self), fresh.pour(self);
  for (Bed* bed : {&shared, &alone, &fresh}) bed->run(0, windows + 50);
  EXPECT_EQ(shared.particles.state_hash(), alone.particles.state_hash());
  EXPECT_EQ(fresh.particles.state_hash(), alone.particles.state_hash());
  // Otherwise the results above would agree because nothing depends on lists.
  EXPECT_LT(alone.particles.rebuilds(), fresh.particles.rebuilds() / 10);
  EXPECT_GT(alone.particles.totals().contacts, alone.particles.totals().particles);
}

TEST_F(Growth, ContinuesFromACheckpoint) {
  const std::string path = "growth_" + std::to_string(world.size()) + ".h5";
  Bed whole(world, skin), first(world, skin), second(world, skin);
  whole.pour(world), first.pour(world);
  whole.run(0, windows);
  first.run(0, windows / 2);
  {
    io::File file(world, path, io::Mode::create);
    first.particles.save(file, "p");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.particles.load(file, "p");
  }
  second.connect();
  EXPECT_EQ(second.particles.grown(), first.particles.grown());
  second.run(windows / 2, windows);
  EXPECT_EQ(second.particles.state_hash(), whole.particles.state_hash());
  world.barrier();
  if (world.root()) std::filesystem::remove(path);
}

TEST_F(Growth, EndsAtFullSizeAndKeepsMasses) {
  Bed bed(world, skin);
  bed.pour(world);
  const double mass = bed.particles.totals().mass;
  std::map<Id, dem::ParticleView> small;
  for (std::size_t i = 0; i < bed.particles.size(); ++i)
    small.emplace(bed.particles[i].id, bed.particles[i]);
  bed.run(0, windows);
  EXPECT_EQ(bed.particles.grown(), 1);
  EXPECT_EQ(bed.particles.totals().mass, mass);
  int seen = 0;
  for (std::size_t i = 0; i < bed.particles.size(); ++i) {
    const dem::ParticleView p = bed.particles[i];
    const auto before = small.find(p.id);
    if (before == small.end()) continue;  // it was received from another rank
    const double times = p.id < grows_from ? 1 : 1 / begin_size;
    EXPECT_DOUBLE_EQ(p.scale / before->second.scale, times) << p.id;
    EXPECT_NEAR(p.volume / before->second.volume, times * times * times, 1e-12) << p.id;
    EXPECT_EQ(p.mass, before->second.mass) << p.id;
    ++seen;
  }
  EXPECT_TRUE(world.size() > 1 || seen == static_cast<int>(small.size()));
}

}  // namespace
}  // namespace trackbed::growth_test
