// Data are bitwise identical after writing and reading, for any numbers of ranks.
#include "trackbed/io/file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <semaphore.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <numeric>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::file_test {
namespace {

par::Comm world() { return par::Comm::world(); }
const Label label{"m/s", "a test's numbers"};

// Uneven on purpose: rank r holds r * 5 rows, so rank 0 has none.
std::size_t rows_of(int rank) { return static_cast<std::size_t>(rank) * 5; }
std::size_t rows_before(int rank) {
  std::size_t rows = 0;
  for (int r = 0; r < rank; ++r) rows += rows_of(r);
  return rows;
}

template <class T>
T value(std::size_t index) {
  return static_cast<T>(mix(index) >> 11) / static_cast<T>(3);
}
template <class T>
std::vector<T> values(std::size_t first, std::size_t count) {
  std::vector<T> list(count);
  for (std::size_t i = 0; i < count; ++i) list[i] = value<T>(first + i);
  return list;
}

template <class T>
class EveryType : public ::testing::Test {};
using Types = ::testing::Types<double, float, std::int64_t, std::uint64_t, std::int32_t,
                               std::int8_t, std::uint8_t>;
TYPED_TEST_SUITE(EveryType, Types);

TYPED_TEST(EveryType, IsBitwiseIdenticalOnAnyRanks) {
  using T = TypeParam;
  const Scratch scratch(std::string("types_") + typeid(T).name());
  constexpr std::size_t columns = 3;
  const std::size_t total = rows_before(world().size());
  {
    File file(world(), scratch / "a.h5", Mode::create);
    const auto mine =
        values<T>(rows_before(world().rank()) * columns, rows_of(world().rank()) * columns);
    file.write<T>("/dem/deep/x", mine, columns, label);
    file.close();
  }
  const auto whole = values<T>(0, total * columns);
  const File together(world(), scratch / "a.h5", Mode::read);
  EXPECT_EQ(together.extent("/dem/deep/x"), (std::vector<std::size_t>{total, columns}));
  EXPECT_EQ(together.read_all<T>("/dem/deep/x"), whole);
  const RowRange mine = row_range(total, world().rank(), world().size());
  EXPECT_EQ(together.read_own_rows<T>("/dem/deep/x"),
            values<T>(mine.begin * columns, mine.count * columns));
  const File alone(par::Comm::self(), scratch / "a.h5", Mode::read);
  EXPECT_EQ(alone.read_own_rows<T>("/dem/deep/x"), whole);
}

TEST(File, ReadsAnyRows) {
  const Scratch scratch("rows");
  {
    File file(world(), scratch / "a.h5", Mode::create);
    file.write<double>(
        "/x", values<double>(world().rank() == 0 ? 0 : 7, world().rank() == 0 ? 7 : 0), 1, label);
  }
  const File file(world(), scratch / "a.h5", Mode::read);
  // Each rank reads other rows, the last rank none.
  const bool last = world().rank() == world().size() - 1 && world().size() > 1;
  const auto begin = static_cast<std::size_t>(world().rank());
  EXPECT_EQ(file.read_rows<double>("/x", begin, last ? 0 : 3), values<double>(begin, last ? 0 : 3));
  EXPECT_THROW(file.read_rows<double>("/x", 5, 3), RunError);
  EXPECT_THROW(file.read_rows<double>("/x", 8, 0), RunError);
  EXPECT_THROW(file.read_rows<double>("/x", 1, SIZE_MAX), RunError);
}

TEST(File, TakesNoRowsAtAll) {
  const Scratch scratch("empty");
  {
    File file(world(), scratch / "a.h5", Mode::create);
    file.write<double>("/none", {}, 3, label);
    file.append<double>("/grows", {}, 1, label);
  }
  const File file(world(), scratch / "a.h5", Mode::read);
  EXPECT_EQ(file.extent("/none"), (std::vector<std::size_t>{0, 3}));
  EXPECT_EQ(file.extent("/grows"), (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(file.read_all<double>("/none").empty());
  EXPECT_TRUE(file.read_own_rows<double>("/grows").empty());
}

TEST(File, GrowsAndIsCutAndGrowsAgain) {
  const Scratch scratch("append");
  const std::string path = scratch / "a.h5";
  const auto append_as = [](File& file, std::size_t first, std::size_t rows) {
    const RowRange mine = row_range(rows, world().rank(), world().size());
    file.append<double>("/history", values<double>(2 * (first + mine.begin), 2 * mine.count), 2,
                        label);
  };
  {
    File file(world(), path, Mode::create);
    append_as(file, 0, 5000);  // more than one chunk
    append_as(file, 5000, 1);
    append_as(file, 5001, 99);
  }
  {
    File file(world(), path, Mode::append);
    EXPECT_EQ(file.extent("/history"), (std::vector<std::size_t>{5100, 2}));
    file.truncate("/history", 4000);
    append_as(file, 4000, 50);
    EXPECT_THROW(file.truncate("/history", 5000), RunError);
    EXPECT_THROW(file.append<double>("/history", {}, 3, label), RunError);
    EXPECT_THROW(file.append<float>("/history", {}, 2, label), RunError);
  }
  const File file(world(), path, Mode::read);
  EXPECT_EQ(file.read_all<double>("/history"), values<double>(0, 2 * 4050));
  EXPECT_EQ(file.text_attribute("/history", "units"), "m/s");
}

// Written by one rank, read by all.
TEST(File, CompressesWithoutLoss) {
  const Scratch scratch("compressed");
  const auto few = [](std::size_t first, std::size_t count) {  // different values
    std::vector<double> made = values<double>(first, count);
    for (double& value : made) value = std::fmod(value, 7);
    return made;
  };
  const auto write = [&](const std::string& name, bool compress) {
    if (!world().root()) return;
    File file(par::Comm::self(), scratch / name, Mode::create);
    if (compress) file.compress();
    for (std::size_t first = 0; first < 20000; first += 7000)
      file.append<double>("/grows", few(2 * first, 14000), 2, label);
    file.write<double>("/table", few(0, 30000), 3, label);
    file.write<double>("/small", values<double>(0, 3), 1, label);
    file.close();
  };
  write("plain.h5", false), write("small.h5", true);
  world().barrier();
  const File plain(world(), scratch / "plain.h5", Mode::read),
      small(world(), scratch / "small.h5", Mode::read);
  for (const char* name : {"/grows", "/table", "/small"}) {
    EXPECT_EQ(small.extent(name), plain.extent(name));
    EXPECT_EQ(small.read_all<double>(name), plain.read_all<double>(name));
    EXPECT_EQ(small.read_own_rows<double>(name), plain.read_own_rows<double>(name));
  }
  EXPECT_LT(std::filesystem::file_size(scratch / "small.h5"),
            std::filesystem::file_size(scratch / "plain.h5") / 2);
}

// Space reserved against a full disk is released: thousands of small files are written per run.
TEST(File, TakesNoMoreDiskThanItHolds) {
  const Scratch scratch("size");
  File file(world(), scratch / "a.h5", Mode::create);
  for (int i = 0; i < 20; ++i) file.append<double>("/x", values<double>(0, 100), 1, label);
  file.close();
  struct stat status {};
  ASSERT_EQ(stat((scratch / "a.h5").c_str(), &status), 0);
  constexpr std::int64_t block = 512, rounding = 16384;  // file systems round up to blocks
  EXPECT_LE(status.st_blocks * block, status.st_size + rounding);
  EXPECT_GE(status.st_size, 20 * 100 * 8);
  // At most two chunks for each rank.
  EXPECT_LE(status.st_size, 20 * 100 * 8 * world().size() + 2 * 32768);
}

TEST(File, KeepsAttributes) {
  const Scratch scratch("attributes");
  {
    File file(world(), scratch / "a.h5", Mode::create);
    file.write<std::int32_t>("/a/x", {}, 1, {"kN/m²", ""});
    file.attribute("/", "title", std::string("first"));
    file.attribute("/", "title", std::string("second"));
    file.attribute("/made/here", "time", 0.1);
    file.attribute("/a/x", "window", std::int64_t{1} << 60);
    file.attribute("/a", "Version", std::vector<std::int64_t>{1, 0});
  }
  const File file(world(), scratch / "a.h5", Mode::read);
  EXPECT_EQ(file.text_attribute("/a/x", "units"), "kN/m²");
  EXPECT_EQ(file.text_attribute("/a/x", "long_name"), "");
  EXPECT_EQ(file.text_attribute("/", "title"), "second");
  EXPECT_EQ(file.number_attribute("/made/here", "time"), 0.1);
  EXPECT_EQ(file.integer_attribute("/a/x", "window"), std::int64_t{1} << 60);
  EXPECT_EQ(file.names("/"), (std::vector<std::string>{"a", "made"}));
  EXPECT_TRUE(file.has("/") && file.has("/a") && file.has("/a/x"));
  EXPECT_FALSE(file.has("/a/y") || file.has("/b/x/y") || file.has("/a/x/y"));
  EXPECT_THROW(file.integer_attribute("/a", "Version"), RunError);
  EXPECT_THROW(file.number_attribute("/a/x", "window"), RunError);
  EXPECT_THROW(file.text_attribute("/a/x", "nothing"), RunError);
}

// A semaphore left on its node by a run of Open MPI's OMPIO that was killed while it opened a file.
TEST(File, LabelsDimensionsWithAxes) {
  const Scratch scratch("axes");
  const std::size_t root = world().root() ? 1 : 0;
  {
    File file(world(), scratch / "a.h5", Mode::create);
    const std::vector<double> x{0.3, 0.9, 1.5}, time{0, 1};
    file.write<double>("/places/x", std::span(x).first(root * 3), 1, label);
    for (const char* path : {"/history/time", "/history/a", "/history/b"})
      file.append<double>(path, std::span(time).first(root * 2), 1, label);
    file.append<double>("/history/u", values<double>(0, root * 6), 3, label);
    file.link("/history/x", "/places/x");
    EXPECT_FALSE(file.is_axis("/places/x"));
    file.set_axis("/history/u", 1, "/history/x");
    for (const char* path : {"/history/a", "/history/b", "/history/u"})
      file.set_axis(path, 0, "/history/time");
    EXPECT_THROW(file.link("/history/u", "/places/x"), RunError);  // the name is taken
    EXPECT_THROW(file.set_axis("/history/a", 0, "/history/none"), RunError);
    file.close();
  }
  {
    File file(world(), scratch / "a.h5", Mode::append);  // axes grow with their datasets
    for (const char* path : {"/history/time", "/history/a", "/history/b"})
      file.append<double>(path, values<double>(0, root * 2), 1, label);
    file.close();
  }
  const File file(world(), scratch / "a.h5", Mode::read);
  EXPECT_TRUE(file.is_axis("/places/x") && file.is_axis("/history/x"));
  EXPECT_TRUE(file.is_axis("/history/time") && !file.is_axis("/history/u"));
  EXPECT_TRUE(file.has_axis("/history/u", 0) && file.has_axis("/history/u", 1));
  EXPECT_EQ(file.read_all<double>("/history/x"), (std::vector<double>{0.3, 0.9, 1.5}));
  EXPECT_EQ(file.extent("/history/time").at(0), 4u);
}

// HDF5 1.10 wrote metadata in the middle of a collective write from 256 KB on, and failed.
TEST(File, GrowsInManyDatasets) {
  if (world().size() > 2) GTEST_SKIP() << "thousands of agreements on shared cores take minutes";
  const Scratch scratch("many");
  constexpr std::size_t columns = 3;
  for (const Mode mode : {Mode::create, Mode::append}) {
    File file(world(), scratch / "a.h5", mode);
    for (int k = 0; k < 1200; ++k)
      file.append<double>("/group/" + std::to_string(k), values<double>(0, 2 * columns), columns,
                          label);
    file.close();
  }
  const File file(world(), scratch / "a.h5", Mode::read);
  const std::size_t rows = 4 * static_cast<std::size_t>(world().size());
  EXPECT_EQ(file.extent("/group/1199"), (std::vector<std::size_t>{rows, columns}));
}

TEST(File, OpensDespiteASemaphoreOfAKilledRun) {
  const std::string name = "left_on_" + std::to_string(world().size()) + ".h5";
  const Scratch scratch("left");
  sem_t* locked = sem_open(("/OMPIO_" + name).c_str(), O_CREAT, 0600, 0);
  world().barrier();
  File file(world(), scratch / name, Mode::create);  // would wait for ever
  file.close();
  world().barrier();
  if (locked == SEM_FAILED) GTEST_SKIP() << "no semaphores on this system";
  sem_close(locked);
  if (world().root()) sem_unlink(("/OMPIO_" + name).c_str());
}

TEST(File, SplitsRowsEvenly) {
  for (const std::size_t rows : {0UL, 1UL, 3UL, 100UL, 101UL})
    for (const int size : {1, 2, 3, 7}) {
      std::size_t next = 0;
      for (int rank = 0; rank < size; ++rank) {
        const RowRange mine = row_range(rows, rank, size);
        EXPECT_EQ(mine.begin, next);
        EXPECT_LE(mine.count, rows / static_cast<std::size_t>(size) + 1);
        next += mine.count;
      }
      EXPECT_EQ(next, rows);
    }
}

}  // namespace
}  // namespace trackbed::io::file_test
