// Two masses in series across the interface oscillate in their first mode: a disk on an elastic
// column of one element, and a sleeper on a sphere on a floor. Frequency and motion are known in
// closed form; the error must be proportional to the window, because each side moves under the mean
// force of the previous window (docs/decisions/interface.md).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"
#include "verify/coupling/coupled.hpp"

namespace trackbed::two_mass_test {
namespace {

constexpr double substep = 1e-5;  // s, of the stones: its own error is 100 times smaller
constexpr int periods = 3;

// m1 x1'' = -k1 (x1 - x2), m2 x2'' = k1 (x1 - x2) - k2 x2, both relative to static equilibrium.
struct TwoMasses {
  double m1, k1, m2, k2;  // kg, N/m
  double omega = 0;       // rad/s, first mode
  double ratio = 0;       // x2 over x1 in it
  void solve() {
    Eigen::Matrix2d stiffness, mass;
    stiffness << k1, -k1, -k1, k1 + k2;
    mass << m1, 0, 0, m2;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(stiffness, mass);
    omega = std::sqrt(modes.eigenvalues()[0]);
    ratio = modes.eigenvectors()(1, 0) / modes.eigenvectors()(0, 0);
  }
};

struct Oscillation {
  double omega;  // rad/s, measured
  double error;  // largest deviation of the upper mass from the cosine, over its amplitude
};

// `above`(): height of the upper mass above static equilibrium after each window, m.
template <class Window, class Above>
Oscillation follow(const TwoMasses& exact, double amplitude, double dt, const Window& window,
                   const Above& above) {
  const int windows = static_cast<int>(periods * 2 * std::numbers::pi / exact.omega / dt);
  double last = amplitude, first_crossing = 0, last_crossing = 0, error = 0;
  int crossings = 0;
  for (int w = 1; w <= windows; ++w) {
    window();
    const double now = above(), time = w * dt;
    if (now * last < 0) {
      last_crossing = time - dt * now / (now - last);
      if (crossings++ == 0) first_crossing = last_crossing;
    }
    error = std::max(error, std::abs(now / amplitude - std::cos(exact.omega * time)));
    last = now;
  }
  EXPECT_EQ(crossings, 2 * periods);
  return {std::numbers::pi * (crossings - 1) / (last_crossing - first_crossing), error};
}

dem::Physics springs(double stiffness, double density) {
  dem::ContactLaw law;
  law.k_n = law.k_s = stiffness;
  return test::one_material(law, density);
}

double sphere_mass(double radius, double density) {
  return density * 4 / 3 * std::numbers::pi * std::pow(radius, 3);
}

void put(test::Coupled& scene, const dem::Template& shape, double radius, const Vec3& at) {
  scene.particles.add_template(shape);
  dem::NewParticle one;
  one.scale = radius, one.position = at;
  scene.particles.add(std::span(&one, 1));
}

constexpr fem::Elastic soil{50e6, 0, 2000};
constexpr double radius = 0.3, density = 2500;  // m, kg/m^3

// Plane, 1 m thick: the disk is midway between the two edges of the top, which carry equal parts of
// its force. A column of 1 m x 1 m x 1 m: half its mass oscillates on E A / H.
TwoMasses disk_on_column() {
  const double mass = density * std::numbers::pi * radius * radius;
  TwoMasses exact{mass, 2e7, soil.density / 2, soil.young};
  exact.solve();
  return exact;
}

// The ground is released under a force other than the disk's weight, so that it starts displaced.
Oscillation oscillation_of_disk(double dt) {
  const TwoMasses exact = disk_on_column();
  dem::Domain domain = test::box(Vec3(0, -0.5, -1), Vec3(1, 0.5, 2));
  domain.dimension = Dimension::plane;
  test::Coupled scene(par::Comm::self(), springs(exact.k1, density), domain);
  fem::GroundParameters column = fem::box({1, 1, 1}, {1, 1, 1}, soil);
  column.base = fem::Base::fixed;
  scene.ground.emplace(par::Comm::self(), column, Dimension::plane, 1.0);
  const double weight = exact.m1 * gravity, amplitude = 0.2 * weight / exact.k1;
  const double lower = exact.ratio * amplitude;  // m, of the column's top above equilibrium
  const std::vector<Vec3> held(4, Vec3(0, 0, (exact.k2 * lower - weight) / 4));
  scene.ground->settle(held);
  const double overlap = weight / exact.k1 + lower - amplitude;
  const double begin = radius - overlap;
  put(scene, test::disk(), radius, {0.5, 0, begin});
  scene.register_surfaces();
  scene.coupler.load_mean(0, std::vector<Vec3>(4, Vec3(0, 0, -exact.k1 * overlap / 4)));
  const int substeps = static_cast<int>(std::lround(dt / substep));
  return follow(
      exact, amplitude, dt, [&] { scene.window(dt, substeps); },
      [&] { return scene.particles[0].position.z() - begin + amplitude; });
}

constexpr double stone_radius = 0.1;

TwoMasses sleeper_on_stone(double sleeper_mass) {
  TwoMasses exact{sleeper_mass, 2e7, sphere_mass(stone_radius, density), 3e7};
  exact.solve();
  return exact;
}

// A stiffer contact below than above the stone, so that both surfaces and both laws count.
dem::Physics two_laws(double above, double below) {
  dem::Physics physics = springs(below, density);
  physics.materials.push_back({.name = "sleeper"});
  physics.laws.push_back(physics.laws[0]);
  physics.laws[1].second = "sleeper";
  physics.laws[1].k_n = physics.laws[1].k_s = above;
  return physics;
}

Oscillation oscillation_of_sleeper(double dt) {
  track::SleeperParameters body;
  body.count = 1, body.first = 0, body.free = {"z"}, body.length = 1;
  track::RigidSleepers sleepers(body, Dimension::space, 1, 1);
  const TwoMasses exact = sleeper_on_stone(sleepers.mass());
  test::Coupled scene(par::Comm::self(), two_laws(exact.k1, exact.k2),
                      test::box(Vec3(-1, -1, -1), Vec3(1, 1, 2)));
  scene.sleepers.emplace(std::move(sleepers));
  scene.walls = {test::floor_of(2, 1)};
  const double weight = exact.m1 * gravity, amplitude = 0.2 * weight / exact.k1;
  const double lower = exact.ratio * amplitude;
  const double centre = stone_radius - (weight + exact.m2 * gravity) / exact.k2 + lower;
  put(scene, test::sphere(), stone_radius, {0, 0, centre});
  const double overlap = weight / exact.k1 + lower - amplitude;
  scene.sleepers->place(centre + stone_radius - overlap);
  scene.register_surfaces();
  const std::size_t nodes = scene.sleepers->surfaces()[0].nodes();
  std::vector<Vec3> force(nodes, Vec3(0, 0, exact.k1 * overlap / static_cast<double>(nodes)));
  scene.coupler.load_mean(scene.on_sleeper[0], force);
  const int substeps = static_cast<int>(std::lround(dt / substep));
  const std::vector<double> no_force(1, 0);
  return follow(
      exact, amplitude, dt, [&] { scene.window(dt, substeps, no_force); },
      [&] { return scene.sleepers->state(0).displacement.z() + amplitude; });
}

// The window is halved twice; due to the delay of one window the scheme is of first order.
template <class Of>
void check_order(const TwoMasses& exact, const Of& oscillation) {
  constexpr double coarse = 3.2e-4;  // s, about 1/130 of a period
  std::vector<double> error;
  for (const double dt : {coarse, coarse / 2, coarse / 4}) {
    const Oscillation found = oscillation(dt);
    error.push_back(found.error);
    // Forces that are late by a window dt and are means over it change the frequency in second
    // order, and the amplitude in first order by up to exp(omega^2 dt t / 2).
    const verified::Tolerance late{std::pow(exact.omega * dt, 2) / 4,
                                   "forces a window late: (omega dt)^2 / 8, twice"};
    verified::near(fmt::format("angular frequency, window of {:.2g} s", dt), "rad/s", found.omega,
                   exact.omega, late.of(exact.omega));
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const double order = std::log2(error[k] / error[k + 1]);
    verified::near(fmt::format("order in the window, {:.2g} s", coarse / std::pow(2, k)), "-",
                   order, 1.075,
                   {0.225, "first order; the amplitude grows exponentially, which adds up to 0.2"});
  }
  const verified::Limit growth{
      std::min(0.15, periods * std::numbers::pi * exact.omega * coarse / 4),
      "forces a window late: omega dt / 2 of the phase of three periods"};
  verified::below("error of the motion, shortest window", "-", error[2], growth);
}

TEST(TwoMasses, DiskOnAnElasticColumn) { check_order(disk_on_column(), oscillation_of_disk); }

TEST(TwoMasses, SleeperOnAStone) {
  track::SleeperParameters body;
  body.length = 1;
  const double mass = track::RigidSleepers(body, Dimension::space, 1, 0).mass();
  check_order(sleeper_on_stone(mass), oscillation_of_sleeper);
}

}  // namespace
}  // namespace trackbed::two_mass_test
