// A run resumed from a file is bitwise identical to an uninterrupted one.
#include <gtest/gtest.h>

#include <filesystem>

#include "trackbed/core/error.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::track::sleepers_file_test {
namespace {

void advance(Sleepers& sleepers, int windows) {
  std::vector<double> seat(sleepers.count(), 0);
  for (int k = 0; k < windows; ++k) {
    std::vector<std::vector<Vec3>> lists;
    for (std::size_t i = 0; i < sleepers.count(); ++i) {
      seat[i] = 1e3 * static_cast<double>(i);
      auto& list = lists.emplace_back();
      for (std::size_t n = 0; n < sleepers.surfaces()[i].nodes(); ++n)
        list.push_back(
            Vec3(3.0 * static_cast<double>(n), 0, 100 + sleepers.state(i).displacement.z()));
    }
    sleepers.advance(1e-3, seat, std::vector<std::span<const Vec3>>(lists.begin(), lists.end()),
                     9.81);
  }
}

TEST(SleepersFile, ResumedRunIsBitwiseIdentical) {
  const par::Comm world = par::Comm::world();
  const std::string path = "sleepers_" + std::to_string(world.size()) + ".h5";
  SleeperParameters parameters;
  parameters.bevel = 0.02;
  RigidSleepers straight(parameters, Dimension::plane, 1.3, 0),
      first = RigidSleepers(parameters, Dimension::plane, 1.3, 0),
      second(parameters, Dimension::plane, 1.3, 0);
  straight.place(0.4);
  first.place(0.4);
  advance(straight, 30);
  advance(first, 13);
  {
    io::File file(world, path, io::Mode::create);
    io::Archive::writer(world, file).part("sleepers", first);
    file.close();
  }
  const io::File file(world, path, io::Mode::read);
  io::Archive::reader(file).part("sleepers", second);
  EXPECT_TRUE(second.placed());
  EXPECT_EQ(second.bottom(), 0.4);
  EXPECT_EQ(second.reaction(2), first.reaction(2));
  advance(second, 17);
  for (std::size_t i = 0; i < straight.count(); ++i) {
    EXPECT_EQ(second.state(i).displacement, straight.state(i).displacement);
    EXPECT_EQ(second.state(i).rotation, straight.state(i).rotation);
    EXPECT_EQ(second.state(i).velocity, straight.state(i).velocity);
    EXPECT_EQ(second.state(i).spin, straight.state(i).spin);
    EXPECT_GT(straight.state(i).rotation.norm(), 0);
    for (std::size_t n = 0; n < straight.surfaces()[i].nodes(); ++n)
      EXPECT_EQ(second.surfaces()[i].motion[n], straight.surfaces()[i].motion[n]);
  }
}

TEST(SleepersFile, AnotherNumberOfSleepersIsRefused) {
  const par::Comm world = par::Comm::world();
  const std::string path = "sleepers_other_" + std::to_string(world.size()) + ".h5";
  SleeperParameters fewer;
  fewer.count = 2;
  RigidSleepers first({}, Dimension::plane, 1.3, 0), second(fewer, Dimension::plane, 1.3, 0);
  first.place(0.4);
  {
    io::File file(world, path, io::Mode::create);
    io::Archive::writer(world, file).part("sleepers", first);
    file.close();
  }
  const io::File file(world, path, io::Mode::read);
  EXPECT_THROW(io::Archive::reader(file).part("sleepers", second), RunError);
}

}  // namespace
}  // namespace trackbed::track::sleepers_file_test
