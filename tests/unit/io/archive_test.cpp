// One function of a class saves its state and loads it on any number of ranks; what does not fit
// the model is refused.
#include "trackbed/io/archive.hpp"

#include <gtest/gtest.h>

#include "trackbed/core/error.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::archive_test {
namespace {

enum class Colour { red, green };

struct Wheel {
  Vec3 place = Vec3::Zero();
  Quat attitude = Quat::Identity();
  double load = 0;
};

struct Wagon {
  std::vector<Wheel> wheels;
  Colour colour = Colour::red;
  bool brakes = false;
  std::int64_t trips = 0;
  Vec3 centre = Vec3::Zero();
  Eigen::VectorXd motion;
  std::vector<double> log;
  double tare = 0;

  void archive(Archive& a) {
    a.rows("place", wheels, {"m", "of each wheel"}, &Wheel::place);
    a.rows("attitude", wheels, {"-", "of each wheel"}, &Wheel::attitude);
    a.rows("load", wheels, {"N", "of each wheel"}, [](Wheel& w) -> double& { return w.load; });
    a("colour", colour, {"-", "1: green"});
    a("brakes", brakes, {"-", "1: on"});
    a("trips", trips, {"-", "up to now"});
    a("centre", centre, {"m", "of mass"});
    a("motion", motion, {"m", "of unknowns"});
    a("log", log, {"s", "times"});
    if (a.has("tare", tare > 0)) a("tare", tare, {"kg", "if it is known"});
  }
};

Wagon example() {
  return {.wheels = {{{1, 2, 3}, {0.5, 0.5, -0.5, 0.5}, 4}, {{5, 6, 7}, {0, 1, 0, 0}, 8}},
          .colour = Colour::green,
          .brakes = true,
          .trips = std::int64_t{1} << 60,
          .centre = {0.1, 0.2, 0.3},
          .motion = Eigen::Vector3d(1e-300, -0.0, 1.0 / 3),
          .log = {1, 2}};
}

Wagon empty(std::size_t wheels) {
  Wagon wagon;
  wagon.wheels.resize(wheels);
  wagon.motion = Eigen::VectorXd::Zero(3);
  return wagon;
}

class ArchiveTest : public ::testing::Test {
 protected:
  void save(Wagon wagon) {
    File file(world_, scratch_ / "wagon.h5", Mode::create);
    Archive archive = Archive::writer(world_, file);
    archive.group("train").part("wagon", wagon);
    file.close();
  }
  void load(Wagon& wagon) {
    const File file(world_, scratch_ / "wagon.h5", Mode::read);
    Archive::reader(file).part("train/wagon", wagon);
  }
  // The message of the refusal, or nothing.
  std::string refusal(Wagon wagon) {
    try {
      load(wagon);
    } catch (const RunError& error) {
      return error.what();
    }
    return "";
  }

  par::Comm world_ = par::Comm::world();
  Scratch scratch_{"archive"};
};

TEST_F(ArchiveTest, LoadedIsBitwiseWhatWasSaved) {
  const Wagon saved = example();
  save(saved);
  Wagon loaded = empty(2);
  loaded.log = {9, 9, 9};
  load(loaded);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(loaded.wheels[i].place, saved.wheels[i].place);
    EXPECT_EQ(loaded.wheels[i].attitude.coeffs(), saved.wheels[i].attitude.coeffs());
    EXPECT_EQ(loaded.wheels[i].load, saved.wheels[i].load);
  }
  EXPECT_EQ(loaded.colour, Colour::green);
  EXPECT_TRUE(loaded.brakes);
  EXPECT_EQ(loaded.trips, saved.trips);
  EXPECT_EQ(loaded.centre, saved.centre);
  EXPECT_EQ(loaded.motion, saved.motion);
  EXPECT_TRUE(std::signbit(loaded.motion[1]));
  EXPECT_EQ(loaded.log, saved.log);
  EXPECT_EQ(loaded.tare, 0);
}

TEST_F(ArchiveTest, DatasetsHaveNamesShapesAndIntegers) {
  save(example());
  const File file(world_, scratch_ / "wagon.h5", Mode::read);
  EXPECT_EQ(file.extent("train/wagon/attitude"), (std::vector<std::size_t>{2, 4}));
  EXPECT_EQ(file.extent("train/wagon/load"), (std::vector<std::size_t>{2, 1}));
  EXPECT_EQ(file.extent("train/wagon/centre"), (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(file.read_all<std::int64_t>("train/wagon/brakes"), std::vector<std::int64_t>{1});
  EXPECT_FALSE(file.has("train/wagon/tare"));
}

TEST_F(ArchiveTest, OptionalValuesAreReadWhereTheyAre) {
  Wagon saved = example();
  saved.tare = 12e3;
  save(saved);
  Wagon loaded = empty(2);
  load(loaded);
  EXPECT_EQ(loaded.tare, 12e3);
}

TEST_F(ArchiveTest, OtherShapesAreRefused) {
  save(example());
  EXPECT_EQ(refusal(empty(2)), "");
  EXPECT_EQ(refusal(empty(3)),
            "dataset train/wagon/place of the checkpoint has 2 rows, but the model has 3: the "
            "checkpoint is damaged; continue from another checkpoint");
  Wagon stiffer = empty(2);
  stiffer.motion = Eigen::VectorXd::Zero(4);
  EXPECT_EQ(refusal(stiffer),
            "dataset train/wagon/motion of the checkpoint has 3 rows, but the model has 4: the "
            "checkpoint is damaged; continue from another checkpoint");
  const File file(world_, scratch_ / "wagon.h5", Mode::read);
  Archive archive = Archive::reader(file).group("train").group("wagon");
  std::vector<double> six(6);
  EXPECT_THROW(archive.table("place", six, 2, {}), RunError);  // as many numbers, as 3 x 2
  double one = 0;
  EXPECT_THROW(archive("log", one, {}), RunError);
  EXPECT_THROW(archive("trips", one, {}), RunError);  // an integer
  EXPECT_THROW(archive("wings", one, {}), RunError);
}

}  // namespace
}  // namespace trackbed::io::archive_test
