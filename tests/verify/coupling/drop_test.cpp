// A sphere dropped beside the middle of an elastic plate of elements, against the same drop with
// windows at least ten times shorter. On any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"
#include "verify/coupling/coupled.hpp"

namespace trackbed::drop_test {
namespace {

constexpr double substep = 1e-5;                   // s, of the stones in every run
constexpr double interval = 4e-3, duration = 0.1;  // s, impact of the sphere at 0.05 s
constexpr double radius = 0.15;                    // m

fem::GroundParameters plate() {
  fem::GroundParameters p = fem::box({1.2, 1.2, 0.3}, {6, 6, 2}, {20e6, 0.25, 1800});
  p.base = fem::Base::fixed;
  return p;
}

struct Drop {
  std::vector<double> height, speed, deflection;  // m, m/s, m below the sphere, each `interval`
};

// Of one node, which may be on any rank.
double deflection(const test::Coupled& scene, std::int32_t node) {
  double mine = 0;
  for (const std::int32_t own : scene.ground->own_top())
    if (own == node) mine = scene.ground->top_state(own).displacement.z();
  return scene.comm.sum(mine);
}

Drop drop(double window) {
  const par::Comm world = par::Comm::world();
  dem::ContactLaw law;
  law.k_n = law.k_s = 2e6;
  law.zeta_n = 0.1;
  test::Coupled scene(world, test::one_material(law),
                      test::box(Vec3(0, 0, -0.5), Vec3(1.2, 1.2, 1)));
  scene.ground.emplace(world, plate(), Dimension::space, 1.0);
  scene.ground->settle(std::vector<Vec3>(scene.ground->top().nodes(), Vec3::Zero()));
  scene.particles.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = radius, one.position = Vec3(0.63, 0.55, radius + 0.0123);
  scene.particles.add(std::span(&one, world.root() ? 1 : 0));
  scene.register_surfaces();
  Drop result;
  const int between = static_cast<int>(std::lround(interval / window));
  const int substeps = static_cast<int>(std::lround(window / substep));
  constexpr std::int32_t middle = 3 + 7 * 3;
  for (double t = 0; t < duration; t += interval) {
    for (int w = 0; w < between; ++w) scene.window(window, substeps);
    Vec3 mine = Vec3::Zero();
    if (scene.particles.size() > 0)
      mine = Vec3(scene.particles[0].position.z(), scene.particles[0].velocity.z(), 0);
    result.height.push_back(world.sum(mine.x()));
    result.speed.push_back(world.sum(mine.y()));
    result.deflection.push_back(deflection(scene, middle));
  }
  return result;
}

// Largest difference over the largest magnitude.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double gap = 0, scale = 0;
  for (std::size_t k = 0; k < b.size(); ++k) {
    gap = std::max(gap, std::abs(a[k] - b[k]));
    scale = std::max(scale, std::abs(b[k]));
  }
  return gap / scale;
}

TEST(Drop, AgreesWithAReferenceOfHighResolution) {
  const Drop reference = drop(1e-5);
  double low = 0;
  for (const double z : reference.deflection) low = std::min(low, z);
  EXPECT_LT(low, -1e-4);  // m: the plate must deflect for the test to be meaningful
  std::vector<double> error;
  for (const double window : {4e-4, 2e-4, 1e-4}) {
    const Drop found = drop(window);
    error.push_back(std::max({difference(found.height, reference.height),
                              difference(found.speed, reference.speed),
                              difference(found.deflection, reference.deflection)}));
    if (par::Comm::world().root())
      std::printf("window %.0e s: height %.1e, speed %.1e, deflection %.1e\n", window,
                  difference(found.height, reference.height),
                  difference(found.speed, reference.speed),
                  difference(found.deflection, reference.deflection));
  }
  const verified::Tolerance half{0.1,
                                 "first order: 1/2, less with the reference's own window: 0.47"};
  verified::near("error left by half the window", "-", error[1] / error[0], 0.5, half);
  verified::near("error left by half of that", "-", error[2] / error[1], 0.5, half);
  verified::below("error, window of 0.1 ms", "-", error[2],
                  {0.05, "first order: the window is a hundredth of the collision, five times"});
}

}  // namespace
}  // namespace trackbed::drop_test
