// Rows of the histories in the file after any sequence of flushes, and the two files that take
// turns.
#include "trackbed/observe/results.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "support/scene.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::observe::results_test {
namespace {

// Results of a model without stones, whose rows have one wall of two forces.
struct Model {
  explicit Model(const std::string& file)
      : path(file),
        particles(par::Comm::world(), test::one_material({}, 2500), {},
                  test::box(Vec3::Constant(-1), Vec3::Constant(1))),
        results(par::Comm::world(), path, {.deck = "title = \"rows\"", .version = "0"}) {
    results.begin(scene(), {});
  }
  Scene scene() const { return {.particles = particles, .stones = false}; }
  void sample(int rows) {
    for (int k = 0; k < rows; ++k, ++sampled) {
      const WallState wall{.name = "wall", .force = Vec3(1, 2, sampled)};
      Instant instant;
      instant.time = 0.5 * sampled, instant.stage = sampled / 10;
      instant.walls = std::span(&wall, 1);
      results.sample(scene(), instant);
    }
  }
  // Rows 0, 1, 2 and so on in the file.
  void expect_rows(int rows) const {
    const io::File file = open_results(par::Comm::world(), path);
    const auto time = file.read_all<double>("history/time");
    const auto force = file.read_all<double>("history/wall/wall/force");
    ASSERT_EQ(time.size(), static_cast<std::size_t>(rows));
    ASSERT_EQ(force.size(), 3 * time.size());
    for (std::size_t k = 0; k < time.size(); ++k) {
      EXPECT_EQ(time[k], 0.5 * static_cast<double>(k));
      EXPECT_EQ(force[3 * k + 2], static_cast<double>(k));
    }
  }

  std::string path;
  dem::Particles particles;
  Results results;
  int sampled = 0;
};

// Number of the file on the disk.
ino_t file_number(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(stat(path.c_str(), &status), 0) << path;
  return status.st_ino;
}

TEST(Results, HaveAllRowsAfterEachFlush) {
  const io::Scratch scratch("rows");
  Model run(scratch / "results.h5");
  for (const int rows : {3, 1, 10, 0, 2, 7}) {
    run.sample(rows);
    run.results.flush();
    run.expect_rows(run.sampled);
  }
  run.sample(4);
  run.results.snapshot("rest", run.scene(), 0);
  run.expect_rows(run.sampled);
  for (const int rows : {5, 2}) {
    run.sample(rows);
    run.results.flush();
    run.expect_rows(run.sampled);
  }
  EXPECT_TRUE(open_results(par::Comm::world(), run.path).has("chains/rest"));
}

// A run that is killed while it creates the file would otherwise leave one that cannot be opened,
// and could not be started again without the user. Another name of the old file shows whether that
// was overwritten.
TEST(Results, BeginInAFileOfTheirOwn) {
  const io::Scratch scratch("begin");
  const std::string path = scratch / "results.h5", kept = scratch / "kept";
  const par::Comm world = par::Comm::world();
  if (world.root()) {
    std::ofstream(path) << "old";
    std::filesystem::create_hard_link(path, kept);
  }
  world.barrier();
  const Model run(path);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  EXPECT_EQ(std::filesystem::file_size(kept), 3U);
  EXPECT_EQ(open_results(world, path).text_attribute("/", "deck"), "title = \"rows\"");
}

// Whether the file system of a folder can do it; network file systems may not.
bool can_exchange(const io::Scratch& scratch) {
  const par::Comm world = par::Comm::world();
  bool can = false;
  if (world.root()) {
    const std::string one = scratch / "one", other = scratch / "other";
    std::ofstream(one) << 1, std::ofstream(other) << 2;
    can = renameat2(AT_FDCWD, one.c_str(), AT_FDCWD, other.c_str(), RENAME_EXCHANGE) == 0;
  }
  return !world.broadcast(can ? "can" : "").empty();
}

// Otherwise each flush would copy all rows: the cost of a run would grow with the square of its
// length.
TEST(Results, ExchangeTwoFilesAtAFlush) {
  const io::Scratch scratch("twins");
  if (!can_exchange(scratch)) GTEST_SKIP() << "this file system cannot exchange names of files";
  const std::string path = scratch / "results.h5", twin = path + ".part";
  {
    Model run(path);
    run.sample(2);
    run.results.flush();
    const ino_t first = file_number(path), second = file_number(twin);
    EXPECT_NE(first, second);
    for (int flush = 0; flush < 4; ++flush) {
      run.sample(3);
      run.results.flush();
      EXPECT_EQ(file_number(path), flush % 2 ? first : second);
      EXPECT_EQ(file_number(twin), flush % 2 ? second : first);
      par::Comm::world().barrier();
    }
  }
  par::Comm::world().barrier();
  EXPECT_FALSE(std::filesystem::exists(twin)) << "remains after the run";
  EXPECT_TRUE(std::filesystem::exists(path));
}

// A reader who opened the file before two flushes reads the same rows afterwards.
TEST(Results, AreCompressedAtTheEnd) {
  const io::Scratch scratch("results_compressed");
  Model model(scratch / "results.h5");
  model.sample(20000);
  model.results.flush();
  const auto plain = std::filesystem::file_size(model.path);
  model.sample(1);  // is still in memory
  EXPECT_EQ(model.results.compress(), "");
  model.expect_rows(20001);
  par::Comm::world().barrier();
  EXPECT_LT(std::filesystem::file_size(model.path), plain / 2);
  EXPECT_FALSE(std::filesystem::exists(model.path + ".part"));
}

// A folder in the place of the part: no file can be made.
TEST(Results, StayAsTheyAreIfTheyCannotBeCompressed) {
  const io::Scratch scratch("results_not_compressed");
  Model model(scratch / "results.h5");
  model.sample(50);
  model.results.flush();
  const par::Comm comm = par::Comm::world();
  if (comm.root()) {
    std::filesystem::remove(model.path + ".part");
    std::filesystem::create_directories(model.path + ".part/full");
  }
  comm.barrier();
  const std::string why = model.results.compress();
  EXPECT_NE(why.find("results.h5.part"), std::string::npos) << why;
  EXPECT_EQ(why.find("rank 0: rank 0"), std::string::npos) << why;
  model.expect_rows(50);
}

TEST(Results, LeaveAFileThatIsReadToItsReader) {
  const io::Scratch scratch("reader");
  const par::Comm world = par::Comm::world();
  Model run(scratch / "results.h5");
  run.sample(2);
  run.results.flush();
  int reader = -1;
  if (world.root()) {
    reader = open(run.path.c_str(), O_RDONLY);
    ASSERT_EQ(flock(reader, LOCK_SH), 0);  // as HDF5 does
  }
  const auto contents = [&] {
    struct stat status {};
    fstat(reader, &status);
    std::string bytes(static_cast<std::size_t>(status.st_size), 0);
    EXPECT_EQ(pread(reader, bytes.data(), bytes.size(), 0), status.st_size);
    return bytes;
  };
  const std::string before = world.root() ? contents() : "";
  for (int flush = 0; flush < 3; ++flush) {
    run.sample(3);
    run.results.flush();
    run.expect_rows(run.sampled);
  }
  if (world.root()) {
    EXPECT_TRUE(contents() == before);
    close(reader);
  }
}

// For example by a user who removes what looks incomplete.
TEST(Results, DoWithoutTheSecondFile) {
  const io::Scratch scratch("removed");
  const par::Comm world = par::Comm::world();
  Model run(scratch / "results.h5");
  for (int flush = 0; flush < 3; ++flush) {
    run.sample(2);
    run.results.flush();
    run.expect_rows(run.sampled);
    if (world.root()) std::filesystem::remove(run.path + ".part");
    world.barrier();
  }
}

}  // namespace
}  // namespace trackbed::observe::results_test
