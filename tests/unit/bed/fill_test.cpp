// Bitwise identical beds on any number of ranks.
#include <gtest/gtest.h>

#include <map>

#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::bed::fill_test {
namespace {

struct Bed {
  par::Comm world = par::Comm::world();
  BedParameters parameters;
  dem::Physics physics;
  dem::Domain domain;
  Bed() {
    parameters.x = {0, 2};
    parameters.height = 0.3;
    physics.materials.push_back({.name = "steel"});
    physics.materials.push_back({.name = "ballast"});
    for (const char* other : {"steel", "ballast"})
      physics.laws.push_back({.first = "ballast", .second = other});
    domain.dimension = Dimension::plane;
    domain.thickness = 1.3;
    domain.low = {0, -0.65, -0.2};
    domain.high = {2, 0.65, 5};
  }
};

TEST(Fill, EveryStoneExistsOnce) {
  Bed bed;
  dem::Particles particles(bed.world, bed.physics, {}, bed.domain);
  const double height = fill(particles, bed.world, bed.parameters, 1);
  const std::int64_t expected = stones_of(bed.world, bed.parameters, bed.domain).count;
  EXPECT_EQ(bed.world.sum(static_cast<std::int64_t>(particles.size())), expected);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    sum += stone.id;
    EXPECT_EQ(stone.material, 1);
    EXPECT_LT(stone.position.z(), height);
  }
  EXPECT_EQ(bed.world.sum(sum), expected * (expected - 1) / 2);
  const dem::Totals totals = particles.totals();
  const double wanted = 2650 * 1.3 * 2 * 0.3 * 0.6;  // kg
  EXPECT_NEAR(totals.mass, wanted, 0.01 * wanted);
}

TEST(Fill, AnyNumberOfRanksMakesTheBedOfOne) {
  Bed bed;
  dem::Particles shared(bed.world, bed.physics, {}, bed.domain);
  const par::Comm self = par::Comm::self();
  dem::Particles alone(self, bed.physics, {}, bed.domain);
  EXPECT_EQ(fill(shared, bed.world, bed.parameters, 1), fill(alone, self, bed.parameters, 1));
  std::map<Id, dem::ParticleView> all;
  for (std::size_t i = 0; i < alone.size(); ++i) all.emplace(alone[i].id, alone[i]);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const dem::ParticleView stone = shared[i];
    const dem::ParticleView& same = all.at(stone.id);
    EXPECT_EQ(stone.position, same.position);
    EXPECT_EQ(stone.attitude.coeffs(), same.attitude.coeffs());
    EXPECT_EQ(stone.mass, same.mass);
    EXPECT_EQ(stone.shape, same.shape);
  }
  EXPECT_EQ(shared.state_hash(), alone.state_hash());
}

// A height that was not checked before is an error of the run, and no stones are added.
TEST(Fill, ADomainThatIsTooLowIsRejected) {
  Bed bed;
  bed.domain.high.z() = 0.2;
  dem::Particles particles(bed.world, bed.physics, {}, bed.domain);
  EXPECT_GT(stones_of(bed.world, bed.parameters, bed.domain).top, 0.2);
  EXPECT_THROW(fill(particles, bed.world, bed.parameters, 1), RunError);
  EXPECT_EQ(particles.totals().particles, 0);
}

// Both place the stones in the same way.
TEST(Fill, TheHeightIsPredicted) {
  const Bed bed;
  dem::Particles particles(bed.world, bed.physics, {}, bed.domain);
  EXPECT_EQ(stones_of(bed.world, bed.parameters, bed.domain).top,
            fill(particles, bed.world, bed.parameters, 1));
}

}  // namespace
}  // namespace trackbed::bed::fill_test
