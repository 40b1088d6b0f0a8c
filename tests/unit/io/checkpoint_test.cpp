// A checkpoint is complete or absent, and any number of ranks can read it.
#include "trackbed/io/checkpoint.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "io/seal.hpp"
#include "trackbed/core/error.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::checkpoint_test {
namespace {

namespace fs = std::filesystem;
par::Comm world() { return par::Comm::world(); }

// The same content on any number of ranks.
void fill(File& file, double start) {
  const RowRange mine = row_range(101, world().rank(), world().size());
  std::vector<double> x(2 * mine.count);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = start + static_cast<double>(2 * mine.begin + i);
  file.write<double>("/dem/x", x, 2, {"m", "positions"});
  file.attribute("/", "time", start);
}

void write(const Scratch& scratch, const std::string& name, double start) {
  write_checkpoint(world(), scratch.folder(), name, [&](File& file) { fill(file, start); });
}

std::string refusal(const std::string& path) {
  try {
    open_latest(world(), path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "opened";
}

void on_root(const std::function<void()>& act) {
  world().barrier();
  if (world().root()) act();
  world().barrier();
}

TEST(Checkpoint, IsReadByAnyNumberOfRanks) {
  const Scratch scratch("checkpoint");
  write(scratch, "one.h5", 1);
  write(scratch, "two.h5", 2);
  for (const par::Comm& comm : {world(), par::Comm::self()}) {
    const File file = open_latest(comm, scratch.folder());  // the latest
    EXPECT_EQ(file.number_attribute("/", "time"), 2);
    const auto x = file.read_all<double>("/dem/x");
    ASSERT_EQ(x.size(), 202U);
    EXPECT_EQ(x[201], 203);
    EXPECT_FALSE(file.text_attribute("/", "trackbed_version").empty());
  }
  EXPECT_EQ(open_checkpoint(world(), scratch / "one.h5").number_attribute("/", "time"), 1);
}

// Otherwise the number of ranks could not be changed at a restart.
TEST(Checkpoint, TheNewestValidOneIsFoundIfTheLatestIsNot) {
  const Scratch scratch("newest");
  for (const char* name : {"one.h5", "two.h5", "three.h5"}) write(scratch, name, 1);
  EXPECT_EQ(choose_checkpoint(world(), scratch.folder(), IfDamaged::pass_over).file,
            scratch / "three.h5");
  on_root([&] {  // "one" is the older by its time; a results file is no checkpoint
    fs::resize_file(scratch / "three.h5", 1000);
    const auto now = fs::last_write_time(scratch / "two.h5");
    fs::last_write_time(scratch / "one.h5", now - std::chrono::hours(1));
    std::ofstream(scratch / "results.h5") << "no checkpoint";
  });
  const CheckpointChoice newest =
      choose_checkpoint(world(), scratch.folder(), IfDamaged::pass_over);
  EXPECT_EQ(newest.file, scratch / "two.h5");
  ASSERT_EQ(newest.passed_over.size(), 1U);
  EXPECT_TRUE(newest.passed_over[0].starts_with(scratch / "three.h5" + ": "));
  EXPECT_EQ(choose_checkpoint(world(), scratch.folder(), IfDamaged::refuse).file,
            scratch / "three.h5");
  on_root([&] {
    fs::remove(scratch / "three.h5");
    fs::resize_file(scratch / "two.h5", 1000);
  });
  EXPECT_EQ(choose_checkpoint(world(), scratch.folder(), IfDamaged::pass_over).file,
            scratch / "one.h5");
  on_root([&] { fs::resize_file(scratch / "one.h5", 1000); });
  EXPECT_THROW(choose_checkpoint(world(), scratch.folder(), IfDamaged::pass_over), InputError);
  on_root([] {});
}

TEST(Checkpoint, HasChecksumsThatDoNotDependOnRanks) {
  const Scratch scratch("checksums");
  write(scratch, "all.h5", 1);
  const File file = open_checkpoint(world(), scratch / "all.h5");
  constexpr std::int64_t on_one_rank = 1479718247508051262;  // printed by a run on one rank
  EXPECT_EQ(file.integer_attribute("/dem/x", "checksum"), on_one_rank);
}

TEST(Checkpoint, ReportsTheDefectOfAFile) {
  const Scratch scratch("refusals");
  const std::string path = scratch / "c.h5";
  EXPECT_EQ(refusal(path), path + ": does not exist");
  EXPECT_EQ(refusal(scratch.folder()),
            scratch.folder() +
                ": contains no checkpoint; give the result folder of a run, or a file .h5 in it");
  on_root([&] { std::ofstream(path).close(); });
  EXPECT_EQ(refusal(path), path + ": is empty");
  on_root([&] { std::ofstream(path) << "some text of another kind, longer than a header"; });
  EXPECT_EQ(refusal(path), path + ": is not a trackbed checkpoint");
  { File(world(), path, Mode::create).attribute("/", "a", 1.0); }
  EXPECT_EQ(refusal(path), path + ": is not a trackbed checkpoint (or its last bytes are missing)");
  write(scratch, "c.h5", 1);
  const auto whole = fs::file_size(path);
  constexpr std::uintmax_t seal_bytes = 32 + 16;  // one dataset
  on_root([&] { fs::resize_file(path, whole / 2); });
  EXPECT_EQ(refusal(path), path + ": is cut short (it has " + std::to_string(whole / 2) +
                               " bytes and should have more than " +
                               std::to_string(whole - seal_bytes) + ")");
  on_root([&] { fs::remove(path); });
  EXPECT_EQ(refusal(scratch.folder()), path + ": does not exist");
}

TEST(Checkpoint, NamesTheDamagedDatasetAndAnotherFormat) {
  const Scratch scratch("altered");
  const std::string path = scratch / "c.h5";
  write(scratch, "c.h5", 1);
  on_root([&] {  // 77 is element 76: its bytes appear once in the file
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const double value = 77;
    const auto at = bytes.find(std::string(reinterpret_cast<const char*>(&value), sizeof value));
    file.clear();
    file.seekp(static_cast<std::streamoff>(at));
    file.put('\1');
  });
  EXPECT_EQ(refusal(path), path +
                               ": is damaged: dataset /dem/x does not match its checksum; an "
                               "earlier checkpoint of the run may be intact");
  write(scratch, "c.h5", 1);
  on_root([&] {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(200);
    file.put('\1');
  });
  EXPECT_EQ(refusal(path), path +
                               ": is damaged: its structure does not match the checksum at its "
                               "end; an earlier checkpoint of the run may be intact");
  for (const bool newer : {true, false}) {
    const std::int64_t format = checkpoint_format + (newer ? 1 : -1);
    {
      File file(world(), path, Mode::create);
      file.attribute("/", "kind", std::string("trackbed checkpoint"));
      file.attribute("/", "format", format);
    }
    on_root([&] { EXPECT_EQ(seal(path, {}), ""); });
    EXPECT_EQ(refusal(path), path + ": was written by " + (newer ? "a newer" : "an older") +
                                 " version of trackbed (checkpoint format " +
                                 std::to_string(format) + "; this version reads format " +
                                 std::to_string(checkpoint_format) +
                                 "); use that version, or run the deck again");
  }
}

TEST(Checkpoint, LeavesThePreviousOneWhenWritingFails) {
  const Scratch scratch("previous");
  write(scratch, "one.h5", 1);
  EXPECT_THROW(write_checkpoint(world(), scratch.folder(), "two.h5",
                                [](File& file) {
                                  fill(file, 2);
                                  throw RunError("lost a particle");
                                }),
               RunError);
  EXPECT_FALSE(fs::exists(scratch / "two.h5.part"));
  // Files left by a killed writer: incomplete, under the temporary names.
  on_root([&] {
    fs::copy_file(scratch / "one.h5", scratch / "two.h5.part");
    fs::resize_file(scratch / "two.h5.part", 300);
    std::ofstream(scratch / "latest.part") << "two";
  });
  EXPECT_EQ(open_latest(world(), scratch.folder()).number_attribute("/", "time"), 1);
  write(scratch, "two.h5", 2);  // the next writer is not affected by them
  EXPECT_EQ(open_latest(world(), scratch.folder()).number_attribute("/", "time"), 2);
}

TEST(Checkpoint, FailsCleanlyWhereNothingCanBeWritten) {
  const auto nothing = [](File&) {};
  EXPECT_THROW(write_checkpoint(world(), "/proc/no/folder", "a.h5", nothing), RunError);
}

}  // namespace
}  // namespace trackbed::io::checkpoint_test
