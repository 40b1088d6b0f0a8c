// Contacts of particles with surfaces: a face acts as one plane however it is cut.
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace trackbed::particles_surface_test {
namespace {

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = 2e5, law.k_s = 1.5e5;
  law.friction = 0.4;
  law.zeta_n = 0.1;
  return law;
}

constexpr double dt = 2e-5;  // s

// A launched particle that bounces, slides and rolls over a floor cut into 2 n^2 triangles.
dem::ParticleView launched(bool clump, int n, double half) {
  dem::Particles p(par::Comm::self(), test::one_material(rough()), {},
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(clump ? test::clump() : test::sphere());
  dem::NewParticle one;
  one.scale = 0.02;
  one.position = Vec3(-0.11, -0.083, 0.025);
  one.velocity = Vec3(0.6, 0.37, -0.3);
  one.attitude = Quat(1, 0.2, -0.4, 0.1).normalized();
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(n, half);
  p.set_surfaces({&floor});
  for (int k = 0; k < 20; ++k) p.advance(600 * dt, 600);
  EXPECT_EQ(p.trouble(), "");
  EXPECT_LT(p[0].position.z(), 0.025);
  return p[0];
}

TEST(Surface, TrianglesActAsOnePlane) {
  for (const bool clump : {false, true}) {
    const dem::ParticleView whole = launched(clump, 1, 1.9);
    for (const int n : {7, 40}) {
      const dem::ParticleView cut = launched(clump, n, 0.5);
      EXPECT_LT((cut.position - whole.position).norm(), 1e-12) << n;  // m: rounding of 12,000 steps
      EXPECT_LT((cut.spin - whole.spin).norm(), 1e-9) << n;
    }
  }
}

Surface square_bar(double half) {
  Surface s;
  s.name = "bar";
  for (const double x : {-half, half})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-half, half}) s.position.push_back({x, y, z});
  s.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {1, 5, 7}, {1, 7, 3},
                 {0, 2, 6}, {0, 6, 4}, {0, 4, 5}, {0, 5, 1}, {2, 3, 7}, {2, 7, 6}};
  s.motion.assign(s.nodes(), Vec3::Zero());
  s.clear_load();
  return s;
}

// Force on a sphere held at `at` near the surface.
Vec3 force_at(Surface& surface, const Vec3& at) {
  dem::Parameters still;
  still.gravity = 0;
  dem::ContactLaw law = rough();
  law.zeta_n = 0;
  dem::Particles p(par::Comm::self(), test::one_material(law), still,
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = 0.02, one.position = at;
  p.add(std::span(&one, 1));
  p.set_surfaces({&surface});
  p.advance(1e-12, 1);
  return p[0].force;
}

TEST(Surface, AConvexEdgeHasOneContact) {
  Surface bar = square_bar(0.1);
  const double delta = 1e-3, k = 2e5;
  EXPECT_NEAR(force_at(bar, {0.0999, 0, 0.12 - delta}).norm(), k * delta, 1e-6);
  EXPECT_NEAR(force_at(bar, {0.1, 0.01, 0.12 - delta}).norm(), k * delta, 1e-6);
  const double c = (0.02 - delta) / std::sqrt(2.0);
  EXPECT_NEAR(force_at(bar, {0.1 + c, 0.3, 0.1 + c}).norm(), k * delta, 1e-6);
  EXPECT_NEAR(force_at(bar, {0.1 + c, -1 + 1e-9, 0.1 + c}).norm(), k * delta, 1e-6);
  EXPECT_NEAR(force_at(bar, {0.12 - delta, 0, 0}).x(), k * delta, 1e-6);
}

TEST(Surface, AConcaveEdgeHasTwoContacts) {
  Surface corner;
  corner.name = "corner";
  corner.position = {{0, -1, 0}, {0, 1, 0}, {1, -1, 0}, {1, 1, 0}, {0, -1, 1}, {0, 1, 1}};
  corner.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}};  // floor and wall at x = 0
  corner.motion.assign(6, Vec3::Zero());
  corner.clear_load();
  const Vec3 force = force_at(corner, {0.019, 0.1, 0.018});
  EXPECT_NEAR(force.x(), 2e5 * 1e-3, 1e-6);
  EXPECT_NEAR(force.z(), 2e5 * 2e-3, 1e-6);
}

TEST(Surface, ASlightlyBentFloorHasOneContact) {
  Surface floor = test::floor_of(2, 0.5);
  for (Vec3& x : floor.position) x.z() = 1e-3 * std::abs(x.x());  // a valley along y
  const Vec3 force = force_at(floor, {0, 0.11, 0.0195});
  EXPECT_NEAR(force.norm(), 2e5 * 0.5e-3, 2e-2 * 100);  // within the slope's 2 %, not doubled
}

// The floor moves under a ball that spins about the normal: the stretch of friction turns with half
// the ball's spin, that of the contact.
TEST(Surface, AStretchOfFrictionTurnsWithHalfTheSpin) {
  constexpr double v = 1e-3, w = 50, time = 0.02;  // m/s, rad/s, s
  constexpr int steps = 1000;
  dem::ContactLaw law = rough();
  law.friction = 1e3, law.zeta_n = law.zeta_s = 0;
  dem::Particles p(par::Comm::self(), test::one_material(law), {.gravity = 0},
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = 0.02, one.position = Vec3(0.013, 0.007, 0.0199);
  one.held = true, one.spin.z() = w;
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(4, 0.5);
  floor.motion.assign(floor.nodes(), Vec3(-v * time, 0, 0));
  p.set_surfaces({&floor});
  p.advance(time, steps);
  const double a = 0.5 * w * time, size = law.k_s * v / (0.5 * w);
  constexpr double margin = 2e-3;  // half a step of 1000
  EXPECT_NEAR(p[0].force.x(), -size * std::sin(a), margin * size);
  EXPECT_NEAR(p[0].force.y(), -size * (1 - std::cos(a)), margin * size);
}

TEST(Surface, AMovingFloorCarriesTheWeightOfTheSphere) {
  dem::Particles p(par::Comm::self(), test::one_material(rough()), {},
                   test::box(Vec3::Constant(-2), Vec3::Constant(2)));
  p.add_template(test::sphere());
  dem::NewParticle one;
  one.scale = 0.02, one.position = Vec3(0.013, 0.007, 0.02);
  p.add(std::span(&one, 1));
  Surface floor = test::floor_of(4, 0.5);
  p.set_surfaces({&floor});
  p.set_local_damping(0.5);
  const double rise = 1e-5;  // m per window
  for (int window = 0; window < 2000; ++window) {
    floor.clear_load();
    for (std::size_t n = 0; n < floor.nodes(); ++n) {
      floor.position[n].z() = window * rise;
      floor.motion[n] = Vec3(0, 0, rise);
    }
    p.advance(10 * dt, 10);
  }
  const double weight = p[0].mass * gravity;
  EXPECT_NEAR(p[0].position.z(), 2000 * rise + 0.02, 2 * weight / 2e5);
  EXPECT_NEAR(p[0].velocity.z(), rise / (10 * dt), 1e-6);
  double total = 0;
  for (const NodeLoad& load : floor.load)
    total += static_cast<double>(load.force[2]) * floor.load_quantum / 10;
  EXPECT_NEAR(total, -weight, 1e-6 * weight);  // mean over the window's sub-steps
  EXPECT_NEAR(p.surface_action().force.z() / 10, total, 1e-10);
}

}  // namespace
}  // namespace trackbed::particles_surface_test
