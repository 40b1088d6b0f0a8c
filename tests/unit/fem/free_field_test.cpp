// Base motion and free-field columns: bitwise identical on any number of ranks and after a restart,
// and sides that do not disturb a level ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/time/base_motion.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/compared.hpp"
#include "unit/fem/mesh_scene.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem::free_field_test {
namespace {

using par::Comm;

// Two layers with borders within elements, damping of both kinds, waves of both kinds.
GroundParameters level(const std::string& table, Integrator integrator) {
  GroundParameters p = box({5, 3, 4}, {5, 3, 9}, {});
  p.layers = {{"soft", 1.3, {60e6, 0.4, 1700}}, {"stiff", 2.7, {200e6, 0.3, 2000}}};
  p.sides = Sides::free_field;
  p.base_motion = table;
  p.rayleigh_mass = 3, p.rayleigh_stiffness = 2e-5;
  p.integrator = integrator;
  p.tolerance = 1e-12;
  return p;
}

std::string table_of(const Comm& comm) {
  return wave_table(comm, "free_field", {50, 0.03}, 1.0, 0.7, 5e-4);
}

class FreeField : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, FreeField, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// All top nodes have equal motions, with every integrator: the sides have no effect.
TEST_P(FreeField, LevelGroundMovesUniformly) {
  const Comm comm = Comm::world();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark, Integrator::hht,
                                      Integrator::bossak, Integrator::generalized_alpha}) {
    Ground ground(comm, level(table_of(comm), integrator), GetParam(), 1.0);
    ground.settle(none(ground));
    const Spread found = spread_in_a_wave(comm, ground);
    EXPECT_GT(found.largest, 1e-6);
    // Rounding of 1e-16 per window, 60 windows; implicit: the solver's tolerance.
    EXPECT_LT(found.apart / found.largest, integrator == Integrator::explicit_ ? 1e-11 : 1e-8)
        << static_cast<int>(integrator);
  }
}

TEST_P(FreeField, ExplicitRunIsBitwiseIdenticalOnAnyRankCount) {
  const Comm world = Comm::world();
  auto p = level(table_of(world), Integrator::explicit_);
  p.blocks = {{"wall", true, {-1, 0.1, 1.3, 0.1, 0.7, -2, -1, -2}, {3e9, 0.2, 2500}}};
  Ground alone(Comm::self(), p, GetParam(), 1.3), spread(world, p, GetParam(), 1.3);
  for (Ground* ground : {&alone, &spread}) {
    ground->settle(none(*ground));
    const auto load = pressure(*ground, 2e3);
    for (int w = 0; w < 50; ++w) ground->advance(1e-3, load);
  }
  EXPECT_EQ(bits(Comm::self(), alone), bits(world, spread));
  EXPECT_GT(alone.totals().kinetic, 0);
}

TEST_P(FreeField, RestartIsBitwiseIdentical) {
  const Comm world = Comm::world(), self = Comm::self();
  for (const Integrator integrator : {Integrator::explicit_, Integrator::bossak}) {
    const auto p = level(table_of(world), integrator);
    // Implicit results depend on the number of ranks: each rank runs its own ground.
    const bool apart = integrator != Integrator::explicit_;
    const Comm& comm = apart ? self : world;
    const std::string path =
        fmt::format("free_field_{}_{}.h5", world.size(), apart ? world.rank() + 1 : 0);
    Ground straight(comm, p, GetParam(), 1.0), resumed(comm, p, GetParam(), 1.0);
    straight.settle(none(straight));
    for (int w = 0; w < 27; ++w) straight.advance(1e-3, none(straight));
    {
      io::File file(comm, path, io::Mode::create);
      straight.save(file, "ground");
    }
    {
      const io::File file(comm, path, io::Mode::read);
      resumed.load(file, "ground");
    }
    for (Ground* ground : {&straight, &resumed})
      for (int w = 0; w < 20; ++w) ground->advance(1e-3, none(*ground));
    EXPECT_EQ(bits(comm, straight), bits(comm, resumed));
  }
}

// Without free-field columns: bitwise identical on any number of ranks and after a restart.
TEST(WaveBelowAMesh, IsBitwiseIdenticalOnAnyRankCountAndAfterARestart) {
  const Comm world = Comm::world(), self = Comm::self();
  GroundParameters p = of_mesh(TetBox({2, 2, 2}, {2, 2, 2}), "wave_below", {60e6, 0.3, 1900});
  p.borders[4].holds = BorderKind::viscous;
  p.base_motion = table_of(world);
  p.integrator = Integrator::explicit_;
  Ground alone(self, p, Dimension::space, 1.0), spread(world, p, Dimension::space, 1.0);
  for (Ground* ground : {&alone, &spread}) {
    ground->settle(none(*ground));
    for (int w = 0; w < 25; ++w) ground->advance(1e-3, none(*ground));
  }
  EXPECT_EQ(bits(self, alone), bits(world, spread));
  EXPECT_GT(alone.totals().kinetic, 0);
  const std::string path = fmt::format("wave_below_{}.h5", world.size());
  Ground resumed(world, p, Dimension::space, 1.0);
  {
    io::File file(world, path, io::Mode::create);
    spread.save(file, "ground");
  }
  {
    const io::File file(world, path, io::Mode::read);
    resumed.load(file, "ground");
  }
  for (Ground* ground : {&spread, &resumed})
    for (int w = 0; w < 15; ++w) ground->advance(1e-3, none(*ground));
  EXPECT_EQ(bits(world, spread), bits(world, resumed));
}

// Invalid meshes: a wave needs a viscous border below, and no dashpots or supports at the sides.
TEST(WaveBelowAMesh, NeedsAViscousBaseAndSidesThatLetItPass) {
  const Comm world = Comm::world();
  GroundParameters p = of_mesh(TetBox({1, 1, 1}, {1, 1, 1}), "wave_refused", {60e6, 0.3, 1900});
  const auto problems = [&] {
    try {
      look_at_mesh(p);
    } catch (const InputError& error) {
      return error.problems();
    }
    return std::vector<std::string>{};
  };
  const auto contains = [](const std::vector<std::string>& sentences, const std::string& words) {
    return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
      return sentence.find(words) != std::string::npos;
    });
  };
  p.base_motion = table_of(world);
  EXPECT_TRUE(contains(problems(), "no viscous border faces down"));
  p.borders[4].holds = BorderKind::viscous;
  ASSERT_EQ(problems().size(), 2);  // rollers at both ends
  EXPECT_TRUE(contains(problems(), "\"x0\" holds the ground along x"));
  p.borders[0].holds = p.borders[1].holds = BorderKind::free;
  ASSERT_EQ(look_at_mesh(p).warnings.size(), 2);
  EXPECT_TRUE(contains(look_at_mesh(p).warnings, "\"x1\" is free and at an end of the mesh"));
  p.base_motion = wave_table(world, "upwards", {50, 0.03}, 0, 0.7, 5e-4);
  p.borders[0].holds = p.borders[1].holds = BorderKind::roller;
  EXPECT_TRUE(look_at_mesh(p).warnings.empty());
  p.borders[1].holds = BorderKind::viscous;
  ASSERT_EQ(look_at_mesh(p).warnings.size(), 1);
  EXPECT_TRUE(contains(look_at_mesh(p).warnings, "\"x1\" impedes the wave"));
}

TEST(BaseMotion, IsLinearBetweenRowsAndNothingBeyond) {
  const std::string path = fmt::format("before_{}.csv", Comm::world().rank());
  std::ofstream(path) << "time_s,vx_m_s,vz_m_s\n-3,0,0\n-1,2,-4\n1,2,-4\n2,0,0\n";
  const BaseMotion motion(path);
  EXPECT_EQ(motion.at(0), Vec3(2, 0, -4));
  EXPECT_EQ(motion.at(-2), Vec3(1, 0, -2));
  EXPECT_EQ(motion.at(5), Vec3::Zero());
  EXPECT_EQ(motion.at(-5), Vec3::Zero());
  EXPECT_EQ(motion.begin(), -3);
  EXPECT_EQ(motion.end(), 2);
}

// Computed wavelets end with values of rounding size, which must not continue after the end.
TEST(BaseMotion, NegligibleMotionAtBothEndsIsZero) {
  const std::string path = fmt::format("fading_{}.csv", Comm::world().rank());
  std::ofstream(path) << "time_s,vx_m_s,vz_m_s\n0,1.5e-34,0\n1,9e-10,0\n2,1,0\n3,1e-12,1e-12\n"
                         "4,0,1\n5,0,9e-10\n6,0,-1.5e-34\n";
  const BaseMotion motion(path);
  EXPECT_EQ(motion.begin(), 1);
  EXPECT_EQ(motion.end(), 5);
  EXPECT_EQ(motion.at(0.9), Vec3::Zero());
  EXPECT_EQ(motion.at(3), Vec3(1e-12, 0, 1e-12)) << "within a wave every value counts";
  EXPECT_EQ(motion.at(1e12), Vec3::Zero());
}

TEST_P(FreeField, FinishedWaveHasNoEffect) {
  const Comm comm = Comm::world();
  const std::string table = fmt::format("over_on_{}.csv", comm.size());
  if (comm.root())
    std::ofstream(table) << "time_s,vx_m_s,vz_m_s\n-0.1,0,0\n-0.06,0.3,0.2\n-0.02,0,0\n";
  comm.sum(std::int64_t{1});  // no rank reads before the file is written
  for (const Integrator integrator : {Integrator::explicit_, Integrator::bossak}) {
    Ground ground(comm, level(table, integrator), GetParam(), 1.0);
    ground.settle(none(ground));
    EXPECT_EQ(spread_in_a_wave(comm, ground).largest, 0) << static_cast<int>(integrator);
  }
}

// Invalid tables.
TEST(BaseMotion, RefusesWavesThatBeginOrEndInMotion) {
  const auto words = [](const std::string& rows) {
    const std::string path = fmt::format("refused_{}.csv", Comm::world().rank());
    std::ofstream(path) << "time_s,vx_m_s,vz_m_s\n" << rows;
    try {
      const auto p = level(path, Integrator::explicit_);
      Ground ground(Comm::self(), p, Dimension::plane, 1.0);
    } catch (const InputError& error) {
      return error.problems().front();
    }
    return std::string();
  };
  EXPECT_EQ(words("0,0,0\n1,1,0\n2,0,0\n"), "");
  EXPECT_NE(words("0,0,0\n1,1,0\n").find("begin and end at rest"), std::string::npos);
  EXPECT_NE(words("0,0,0.1\n1,0,0\n").find("begin and end at rest"), std::string::npos);
  const std::string ends = words("0,0,0\n1,1,0\n\n2,0,-2e-9\n");
  EXPECT_NE(ends.find(":5: vx_m_s = 0, vz_m_s = -2e-09: the wave must begin and end at rest: the "
                      "speed in the last row must be at most 1e-09 of the largest speed (1 m/s)"),
            std::string::npos)
      << ends;
  EXPECT_NE(words("0,0,0\n").find("at least two rows"), std::string::npos);
  EXPECT_NE(words("0,0,0\n0,0,0\n"), "");
}

}  // namespace
}  // namespace trackbed::fem::free_field_test
