// Settlement of sleepers from cycle to cycle, and its continuation in a resumed run.
#include "model/stages/settlement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model::settlement_test {
namespace {

constexpr double dt = 0.01;                       // s
constexpr std::int64_t windows = 10, cycles = 3;  // cycles end with windows 4, 7 and 10

struct Scene {
  track::SleeperParameters parameters{.count = 2};
  track::RigidSleepers sleepers{parameters, Dimension::plane, 1.3, 0};
  Clock clock{dt, windows};
  Settlement settlement;
  Scene() {
    sleepers.place(0.3);
    settlement.begin(sleepers);
  }
  double z(std::size_t i) const { return sleepers.state(i).displacement.z(); }
  // The second sleeper is loaded downwards, the first one upwards.
  void window() {
    const std::vector<double> forces{-10.0, 20.0};
    sleepers.advance(dt, forces, {}, 0);
    clock.tick();
    settlement.watch(cycles, clock, sleepers);
  }
};

TEST(Settlement, IsThatOfTheSleeperThatSankMostInTheLastWholeCycle) {
  Scene scene;
  double begin = 0, expected = -1;
  for (std::int64_t n = 1; n <= windows; ++n) {
    scene.window();
    if (n == 4 || n == 7 || n == 10) {
      expected = begin - scene.z(1);
      begin = scene.z(1);
      EXPECT_GT(expected, 0);
    }
    EXPECT_EQ(scene.settlement.last(), expected) << "window " << n;
  }
}

TEST(Settlement, RisingSleepersHaveNone) {
  Scene scene;
  for (std::int64_t n = 0; n < 4; ++n) {
    scene.sleepers.advance(dt, std::vector<double>{-10.0, -10.0}, {}, 0);
    scene.clock.tick();
    scene.settlement.watch(cycles, scene.clock, scene.sleepers);
  }
  EXPECT_GT(scene.z(0), 0);
  EXPECT_EQ(scene.settlement.last(), 0);
}

TEST(Settlement, ContinuesFromACheckpoint) {
  const par::Comm world = par::Comm::world();
  const std::string path = "settlement_" + std::to_string(world.size()) + ".h5";
  Scene scene;
  for (int n = 0; n < 5; ++n) scene.window();
  {
    io::File file(world, path, io::Mode::create);
    io::Archive::writer(world, file).part("settlement", scene.settlement);
    file.close();
  }
  Settlement resumed;
  resumed.begin(scene.sleepers);
  const io::File file(world, path, io::Mode::read);
  io::Archive::reader(file).part("settlement", resumed);
  EXPECT_EQ(resumed.last(), scene.settlement.last());
  scene.window();
  scene.window();
  resumed.watch(cycles, scene.clock, scene.sleepers);
  EXPECT_EQ(resumed.last(), scene.settlement.last());
}

TEST(SettlementLaw, BeginsAtZeroAndGrowsByItsExponent) {
  for (const double exponent : {0.0, 0.3, 1.0}) EXPECT_EQ(settlement_law(0, exponent), 0);
  EXPECT_DOUBLE_EQ(settlement_law(99, 0), std::log(100));
  EXPECT_DOUBLE_EQ(settlement_law(99, 0.5), (std::sqrt(100) - 1) / 0.5);
  EXPECT_DOUBLE_EQ(settlement_law(99, 1), 99);
  EXPECT_NEAR(settlement_law(99, 1e-9), settlement_law(99, 0), 1e-7);
}

TEST(SettlementLaw, CountsTrainsAndCycles) {
  EXPECT_EQ(cycles_of({.name = "", .kind = StageKind::passage}), 1);
  EXPECT_EQ(cycles_of({.name = "", .kind = StageKind::passage, .cycles = 4}), 4);
  EXPECT_EQ(cycles_of({.name = "", .kind = StageKind::load}), 0);
  EXPECT_EQ(cycles_of({.name = "", .kind = StageKind::jump, .cycles = 70}), 70);
  EXPECT_EQ(cycles_of({.name = "", .kind = StageKind::tamp, .cycles = 2}), 0);
}

}  // namespace
}  // namespace trackbed::model::settlement_test
