// A ground that is saved and loaded continues bitwise identically, on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "trackbed/core/hash.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::ground_checkpoint_test {
namespace {

using par::Comm;

GroundParameters scene() {
  GroundParameters p = box({3, 1, 1}, {13, 4, 5}, {80e6, 0.3, 1900});
  p.sides = Sides::viscous;
  p.rayleigh_stiffness = 1e-5;
  return p;
}

std::vector<Vec3> load_of(const Surface& top, int window) {
  std::vector<Vec3> force(top.nodes());
  for (std::size_t n = 0; n < force.size(); ++n)
    force[n] = {10 * std::sin(0.3 * static_cast<double>(n) + window), 0, -200.0 - 20 * window};
  return force;
}

std::uint64_t bits(const Comm& comm, const Ground& ground) {
  std::uint64_t sum = 0;
  for (const std::int32_t n : ground.own_top()) {
    const auto state = ground.top_state(n);
    sum += mix(hash_bytes(state.displacement.data(), 24, static_cast<std::uint64_t>(n)));
    sum += mix(hash_bytes(state.velocity.data(), 24, static_cast<std::uint64_t>(n) + 1000));
  }
  return static_cast<std::uint64_t>(comm.sum(static_cast<std::int64_t>(sum)));
}

class Saved : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Saved, ::testing::Values(Dimension::plane, Dimension::space));

TEST_P(Saved, GroundContinuesBitwiseIdentically) {
  const Comm world = Comm::world();
  const std::string path = "ground_checkpoint_on_" + std::to_string(world.size()) + ".h5";
  Ground straight(world, scene(), GetParam(), 1.0);
  const double dt = 2.5 * straight.stable_step();
  straight.settle(load_of(straight.top(), 0));
  for (int w = 0; w < 4; ++w) straight.advance(dt, load_of(straight.top(), w));
  {
    io::File file(world, path, io::Mode::create);
    straight.save(file, "ground");
  }
  std::vector<Vec3> shape;
  for (std::size_t n = 0; n < straight.top().nodes(); ++n)
    shape.push_back(straight.top().position[n] + straight.top().motion[n]);
  for (int w = 4; w < 9; ++w) straight.advance(dt, load_of(straight.top(), w));

  Ground spread(world, scene(), GetParam(), 1.0), alone(Comm::self(), scene(), GetParam(), 1.0);
  {
    const io::File file(world, path, io::Mode::read);
    spread.load(file, "ground");
    alone.load(file, "ground");
  }
  for (const auto n : spread.own_top()) {
    const auto at = static_cast<std::size_t>(n);
    EXPECT_LT((spread.top().position[at] - shape[at]).norm(), 1e-15);  // an ulp of 3 m
  }
  for (int w = 4; w < 9; ++w) {
    spread.advance(dt, load_of(spread.top(), w));
    alone.advance(dt, load_of(alone.top(), w));
  }
  EXPECT_EQ(bits(world, straight), bits(world, spread));
  EXPECT_EQ(bits(world, straight), bits(Comm::self(), alone));
  EXPECT_EQ(straight.totals().steps, spread.totals().steps);
  EXPECT_GT(straight.totals().kinetic, 0);
}

class SavedImplicit : public ::testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(, SavedImplicit,
                         ::testing::Values(Integrator::newmark, Integrator::hht, Integrator::bossak,
                                           Integrator::generalized_alpha));

TEST_P(SavedImplicit, ContinuesBitwiseIdentically) {
  // The next implicit step needs the acceleration and the load of the last window, an explicit one
  // does not. Bitwise identical on the same number of ranks; the test runs on each rank separately.
  const Comm self = Comm::self();
  const std::string path = "ground_newmark_" + std::to_string(Comm::world().rank()) + ".h5";
  GroundParameters parameters = scene();
  parameters.integrator = GetParam();
  Ground straight(self, parameters, Dimension::plane, 1.0);
  const double dt = 5e-4;
  straight.settle(load_of(straight.top(), 0));
  for (int w = 0; w < 4; ++w) straight.advance(dt, load_of(straight.top(), w));
  {
    io::File file(self, path, io::Mode::create);
    straight.save(file, "ground");
  }
  Ground resumed(self, parameters, Dimension::plane, 1.0);
  {
    const io::File file(self, path, io::Mode::read);
    resumed.load(file, "ground");
  }
  for (int w = 4; w < 8; ++w) {
    straight.advance(dt, load_of(straight.top(), w));
    resumed.advance(dt, load_of(resumed.top(), w));
  }
  EXPECT_EQ(bits(self, straight), bits(self, resumed));
  EXPECT_GT(straight.totals().kinetic, 0);
}

}  // namespace
}  // namespace trackbed::fem::ground_checkpoint_test
