// A few disks between ground and a sleeper under an oscillating seat force, over 1e5 windows:
// impulse is conserved, the balance of the coupling is exact to rounding, and energy does not
// drift.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "verify/coupling/disks.hpp"

namespace trackbed::long_balance_test {
namespace {

constexpr test::DiskBed bed{.length = 0.3, .columns = 4, .rows = 2, .damping = 0, .dt = 1e-4};
constexpr int windows = 100'000, period = 2000;      // of the force, windows
constexpr double mean_force = 2e3, amplitude = 1e3;  // N
constexpr int settling = 20'000;                     // windows until the motion repeats

double seat_force(int window) {
  const double phase = 2 * std::numbers::pi * (window % period + 0.5) / period;
  return mean_force + amplitude * std::sin(phase);
}

double energy(const test::Coupled& scene) {
  const dem::Totals stones = scene.particles.totals();
  const fem::GroundTotals ground = scene.ground->totals();
  return stones.kinetic + stones.elastic + ground.kinetic + ground.elastic +
         scene.sleepers->kinetic();
}

// Of all bodies above the ground, Ns.
double momentum(const test::Coupled& scene) {
  return scene.particles.totals().momentum.z() +
         scene.sleepers->mass() * scene.sleepers->state(0).velocity.z();
}

TEST(LongRun, ImpulseAndEnergyBalance) {
  test::Coupled scene(par::Comm::self(), test::disk_physics(bed.damping), test::disk_domain(bed));
  test::fill(scene, bed);
  for (int w = 0; w < 20000; ++w) scene.window(bed.dt, 1);
  test::place_sleeper(scene, bed, {"z"});  // as wide as the bed: it must not tip over
  const double weight = (scene.particles.totals().mass + scene.sleepers->mass()) * gravity;
  double given = 0, received = 0, momentum_before = 0, early = 0;  // Ns, J
  for (int w = 0; w < settling + windows; ++w) {
    if (w == settling) momentum_before = momentum(scene), given = received = 0;
    const std::vector<double> force(1, seat_force(w));
    scene.window(bed.dt, 1, force);
    given += (force[0] + weight) * bed.dt;
    received -= scene.on_ground() * bed.dt;
    if (w == settling + period) early = energy(scene);
  }
  // `early` was taken at phase 0, one window into a cycle.
  const std::vector<double> force(1, seat_force(0));
  scene.window(bed.dt, 1, force);
  const double late = energy(scene);
  const couple::Balance& balance = scene.coupler.balance();
  const double gap = (given - received + momentum(scene) - momentum_before) / given;
  std::printf("impulse %.1e, energy drift %.1e; balance: %.1e %.1e %.1e %.1e\n", gap,
              late / early - 1, balance.force, balance.moment, balance.work, balance.impulse);
  // The sleeper moves under the force of the previous window, which differs by up to 2 pi/2000 of
  // 1 kN.
  verified::below(
      "gap of the impulse over 1e5 windows", "-", std::abs(gap),
      {5e-8, "a force a window late at both ends: 3 N of 2 kN, one of 1e5: 1.6e-8, 3 times"});
  const verified::Limit closed{
      1e-10, "rounding of loads to quanta, 1e-18 of the largest one; a lost load gives 1"};
  verified::below("imbalance of force", "-", balance.force, closed);
  verified::below("imbalance of moment", "-", balance.moment, closed);
  verified::below("imbalance of work", "-", balance.work, closed);
  verified::below("imbalance of impulse", "-", balance.impulse, closed);
  verified::near("energy at the end over the beginning", "-", late / early, 1,
                 {1.2e-3, "disks rattle: scatter of 3e-4 from cycle to cycle, four times"});
}

}  // namespace
}  // namespace trackbed::long_balance_test
