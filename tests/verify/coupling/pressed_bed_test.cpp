// A bed of disks loaded by a sleeper: in static equilibrium all forces balance, and results are
// bitwise identical for any number of ranks and any partition of the stones.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "support/verified.hpp"
#include "verify/coupling/disks.hpp"

namespace trackbed::pressed_bed_test {
namespace {

constexpr test::DiskBed bed{};
constexpr double seat_force = 5e3;  // N

class LoadedBed {
 public:
  explicit LoadedBed(const par::Comm& comm, int windows_between_splits = 0)
      : scene(comm, test::disk_physics(bed.damping), test::disk_domain(bed)),
        between_(windows_between_splits) {
    test::fill(scene, bed);
  }
  void run(double duration, double seat) {
    const std::vector<double> force(1, seat);
    for (double t = 0; t < duration; t += bed.dt) {
      scene.window(bed.dt, 1, force);
      if (between_ > 0 && ++windows_ % between_ == 0) scene.rebalance();
    }
  }
  void load(double fall, double duration) {
    run(fall, 0);
    test::place_sleeper(scene, bed);
    run(duration, seat_force);
  }
  test::Coupled scene;

 private:
  int between_, windows_ = 0;
};

// N, through a horizontal section of the lowest row of elements: their mean stress times area.
double base_reaction(const test::Coupled& scene) {
  const io::Grid grid = scene.ground->fields();
  const io::FieldData& stress = grid.cell_data[0];
  const double element_area = bed.length / 8, lowest = -0.31;  // m^2, m
  double mine = 0;
  for (std::size_t cell = 0; cell * 8 < grid.cells.size(); ++cell) {
    double top = -1;
    for (std::size_t k = 0; k < 8; ++k)
      top = std::max(top, grid.points[static_cast<std::size_t>(grid.cells[8 * cell + k])].z());
    if (top < lowest + 0.02) mine -= stress.values[6 * cell + 2] * element_area;
  }
  return scene.comm.sum(mine);
}

TEST(LoadedBed, ForcesBalanceInStaticEquilibrium) {
  if (par::Comm::world().size() > 1) GTEST_SKIP() << "the other test covers several ranks";
  LoadedBed loaded(par::Comm::self());
  loaded.load(0.5, 5);
  const test::Coupled& scene = loaded.scene;
  // How long stones rock depends on rounding of their initial positions: wait for all of them.
  constexpr double still = 1e-11;  // J; inertia forces are then below 1e-6 of the seat force
  for (int wait = 0; wait < 40 && scene.particles.totals().kinetic > still; ++wait)
    loaded.run(1, seat_force);
  ASSERT_LT(scene.particles.totals().kinetic, still);
  const dem::Totals totals = scene.particles.totals();
  ASSERT_EQ(totals.particles, bed.columns * bed.rows);
  const double sleeper = scene.sleepers->mass() * gravity + seat_force;
  const double whole = sleeper + totals.mass * gravity;
  std::printf("kinetic %.1e J; sleeper %.3e, ground %.3e, base %.3e (relative)\n", totals.kinetic,
              scene.sleepers->reaction(0).z() / sleeper - 1, -scene.on_ground() / whole - 1,
              base_reaction(scene) / whole - 1);
  // An omitted weight would be 10 % or more.
  const verified::Tolerance rest{4e-6,
                                 "inertia of stones with 1e-11 J: 1e-6 of the force, four times"};
  verified::near("force of the stones on the sleeper", "N", scene.sleepers->reaction(0).z(),
                 sleeper, rest.of(sleeper));
  verified::near("force on the ground", "N", -scene.on_ground(), whole, rest.of(whole));
  verified::near("reaction of the base", "N", base_reaction(scene), whole, rest.of(whole));
  const verified::Limit closed{
      1e-10, "rounding of loads to quanta, 1e-18 of the largest one; a lost load gives 1"};
  verified::below("imbalance of force", "-", scene.coupler.balance().force, closed);
  verified::below("imbalance of moment", "-", scene.coupler.balance().moment, closed);
  verified::below("imbalance of work", "-", scene.coupler.balance().work, closed);
  verified::below("imbalance of impulse", "-", scene.coupler.balance().impulse, closed);
}

// Displacements of all top nodes; those of other ranks add zero, which is exact.
std::vector<double> top_of(test::Coupled& scene) {
  std::vector<double> all(3 * scene.ground->top().nodes(), 0.0);
  for (const std::int32_t node : scene.ground->own_top()) {
    const Vec3 u = scene.ground->top_state(node).displacement;
    std::copy_n(u.data(), 3, all.begin() + 3 * static_cast<std::ptrdiff_t>(node));
  }
  scene.comm.sum(std::span<double>(all));
  return all;
}

TEST(LoadedBed, IsBitwiseIdenticalForAnyPartitionAndRanks) {
  constexpr double fall = 0.08, loading = 0.04;  // s, in motion
  constexpr int often = 37;                      // windows
  LoadedBed alone(par::Comm::self()), shared(par::Comm::world()), moving(par::Comm::world(), often);
  for (LoadedBed* one : {&alone, &shared, &moving}) one->load(fall, loading);
  EXPECT_GT(alone.scene.particles.totals().kinetic, 1e-6);  // J
  for (LoadedBed* other : {&shared, &moving}) {
    EXPECT_EQ(other->scene.particles.state_hash(), alone.scene.particles.state_hash());
    EXPECT_EQ(other->scene.sleepers->state(0).displacement,
              alone.scene.sleepers->state(0).displacement);
    EXPECT_EQ(other->scene.sleepers->state(0).rotation, alone.scene.sleepers->state(0).rotation);
    EXPECT_EQ(top_of(other->scene), top_of(alone.scene));
  }
}

}  // namespace
}  // namespace trackbed::pressed_bed_test
