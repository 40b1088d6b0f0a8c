// Every failure results in one message on all ranks, and the program continues.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>

#include "io/seal.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "trackbed/io/file.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::file_failure_test {
namespace {

par::Comm world() { return par::Comm::world(); }
const Label label{"m", "a test's numbers"};

template <class F>
std::string failure_of(F&& act) {
  try {
    act();
  } catch (const RunError& error) {
    return error.what();
  }
  return "no failure";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(FileFailure, NamesAMissingFile) {
  EXPECT_EQ(failure_of([] { File(world(), "no/such/file.h5", Mode::read); }),
            "rank 0: no/such/file.h5: cannot be opened (No such file or directory)");
  EXPECT_EQ(failure_of([] { File(world(), "no/such/file.h5", Mode::create); }),
            "rank 0: no/such/file.h5: cannot be created (No such file or directory)");
  EXPECT_EQ(failure_of([] { File(world(), "/", Mode::read); }),
            "rank 0: /: cannot be opened (not a regular file)");
}

TEST(FileFailure, NamesADatasetThatIsMissingOrOfAnotherType) {
  const Scratch scratch("missing");
  File file(world(), scratch / "a.h5", Mode::create);
  file.write<std::int32_t>("/x", std::vector<std::int32_t>(4, 1), 2, label);
  const std::string start = "rank 0: " + scratch / "a.h5" + ": ";
  const auto missing = failure_of([&] { file.read_all<double>("/dem/x"); });
  EXPECT_TRUE(contains(missing, start + "dataset /dem/x cannot be opened")) << missing;
  EXPECT_EQ(failure_of([&] { file.read_all<double>("/x"); }),
            start + "dataset /x holds 32-bit integers, not 64-bit real numbers");
  const auto twice = failure_of([&] { file.write<double>("/x", {}, 1, label); });
  EXPECT_TRUE(contains(twice, start + "dataset /x cannot be created")) << twice;
  const auto group = failure_of([&] { file.names("/y"); });
  EXPECT_TRUE(contains(group, start + "group /y cannot be listed")) << group;
}

// A file larger than the limit of the process represents a full disk: the same system calls fail
// (EFBIG for ENOSPC).
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit before_{};
};

TEST(FileFailure, SurvivesADiskThatFillsUp) {
  const Scratch scratch("full");
  const std::vector<double> much(200000, 1.5);  // 1.6 MB per rank
  {
    const SmallDisk disk(1 << 20);
    File file(world(), scratch / "full.h5", Mode::create);
    file.write<double>("/small", std::vector<double>(10, 2.0), 1, label);
    const auto text = failure_of([&] { file.write<double>("/much", much, 1, label); });
    EXPECT_TRUE(contains(text, scratch / "full.h5: dataset /much cannot be written")) << text;
  }
  // The next file is written without restriction.
  File file(world(), scratch / "next.h5", Mode::create);
  file.write<double>("/much", much, 1, label);
  file.close();
}

TEST(FileFailure, SurvivesADiskThatFillsUpWhileAppending) {
  const Scratch scratch("full_append");
  const SmallDisk disk(1 << 20);
  File file(world(), scratch / "a.h5", Mode::create);
  const std::vector<double> block(4096, 1.5);
  std::string text = "no failure";
  for (int i = 0; i < 100 && text == "no failure"; ++i)
    text = failure_of([&] { file.append<double>("/history", block, 1, label); });
  EXPECT_TRUE(contains(text, scratch / "a.h5: dataset /history cannot be written")) << text;
}

// Numbers that hardly become smaller.
TEST(FileFailure, SurvivesADiskThatFillsUpWithCompressedRows) {
  const Scratch scratch("full_compressed");
  const par::Comm self = par::Comm::self();
  const std::string path = scratch / ("a" + std::to_string(world().rank()) + ".h5");
  std::mt19937_64 random(1);
  std::vector<double> block(4096);
  for (double& value : block) value = std::ldexp(static_cast<double>(random()), -64);
  std::string text = "no failure";
  {
    const SmallDisk disk(1 << 20);
    File file(self, path, Mode::create);
    file.compress();
    for (int i = 0; i < 100 && text == "no failure"; ++i)
      text = failure_of([&] { file.append<double>("/history", block, 1, label); });
    EXPECT_TRUE(contains(text, path + ": dataset /history cannot be written")) << text;
  }
  File file(self, path, Mode::create);
  file.write<double>("/x", block, 1, label);
  file.close();
}

// The folder is deleted while a checkpoint is written: HDF5 has the file open and does not notice.
TEST(FileFailure, ReportsACheckpointRemovedOrCutDuringWriting) {
  const Scratch scratch("removed");
  const std::string part = scratch / "a.h5.part";
  const auto text = failure_of([&] {
    write_checkpoint(world(), scratch.folder(), "a.h5", [&](File& file) {
      file.write<double>("/x", std::vector<double>(10, 1.5), 1, label);
      if (world().root()) std::filesystem::remove(part);
    });
  });
  EXPECT_EQ(text, "rank 0: " + part + ": cannot be read back (No such file or directory)");
  const Scratch other("cut");
  std::ofstream(other / std::to_string(world().rank())) << "short";
  EXPECT_EQ(seal(other / std::to_string(world().rank()), {{2048, 80}}),
            other / std::to_string(world().rank()) +
                ": cannot be read back (it is shorter than the data written to it)");
}

TEST(FileFailure, KeepsTheLastCheckpointWhenTheDiskFillsUp) {
  const Scratch scratch("full_checkpoint");
  const auto write = [&](const std::string& name, std::size_t count) {
    const std::vector<double> values(count, 1.5);
    write_checkpoint(world(), scratch.folder(), name,
                     [&](File& file) { file.write<double>("/x", values, 1, label); });
  };
  write("good.h5", 10);
  {
    const SmallDisk disk(1 << 20);
    const auto text = failure_of([&] { write("large.h5", 200000); });
    EXPECT_TRUE(contains(text, scratch / "large.h5.part: dataset /x cannot be written")) << text;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch / "large.h5.part"));
  EXPECT_EQ(open_latest(world(), scratch.folder()).extent("/x")[0],
            10 * static_cast<std::size_t>(world().size()));
}

}  // namespace
}  // namespace trackbed::io::file_failure_test
