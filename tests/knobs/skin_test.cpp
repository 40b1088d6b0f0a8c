// The only parameter without effect on results: a wider skin of the neighbour lists reduces the
// number of rebuilds and changes nothing else.
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace trackbed::skin_test {
namespace {

struct Result {
  std::int64_t rebuilds;
  std::uint64_t state;
};

// Spheres in free motion in a box with a floor.
Result run_with(double skin) {
  dem::Parameters parameters;
  parameters.skin = skin;
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e5;
  dem::Particles particles(par::Comm::self(), test::one_material(law), parameters,
                           test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  particles.add_template(test::sphere());
  const auto spheres = test::lattice({3, 3, 3}, 0.06, 0.025, 1);
  particles.add(spheres);
  Surface floor = test::floor_of(2, 1.9);
  particles.set_surfaces({&floor});
  constexpr double dt = 2e-5;  // s
  for (int window = 0; window < 50; ++window) particles.advance(100 * dt, 100);
  EXPECT_EQ(particles.trouble(), "");
  return {particles.rebuilds(), particles.state_hash()};
}

TEST(Skin, ChangesRebuildsButNoResult) {
  const Result thin = run_with(1e-3), wide = run_with(1e-2);
  EXPECT_GT(thin.rebuilds, 2 * wide.rebuilds);
  EXPECT_GT(wide.rebuilds, 0);
  EXPECT_EQ(thin.state, wide.state);
}

}  // namespace
}  // namespace trackbed::skin_test
