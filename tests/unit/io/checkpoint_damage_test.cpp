// Damage anywhere in a checkpoint results in a message or is harmless, never in a crash or in wrong
// numbers.
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::checkpoint_damage_test {
namespace {

const std::vector<double>& content() {
  static const std::vector<double> x = [] {
    std::vector<double> values(600);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.1 * static_cast<double>(i);
    return values;
  }();
  return x;
}

class Damage : public ::testing::Test {
 protected:
  Damage() : scratch_("damage"), path_(scratch_ / "c.h5") {
    write_checkpoint(par::Comm::self(), scratch_.folder(), "c.h5", [](File& file) {
      for (int i = 0; i < 12; ++i)  // enough for the second storage scheme of groups in HDF5
        file.write<double>("/dem/x" + std::to_string(i), content(), 3, {"m", "positions"});
      file.attribute("/dem", "time", 0.5);
    });
    std::ifstream in(path_, std::ios::binary);
    whole_.assign(std::istreambuf_iterator<char>(in), {});
  }
  // True if the file was read, with correct values; false if it was refused.
  bool reads(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    try {
      const File file = open_checkpoint(par::Comm::self(), path_);
      for (int i = 0; i < 12; ++i)
        EXPECT_EQ(file.read_all<double>("/dem/x" + std::to_string(i)), content());
      EXPECT_EQ(file.number_attribute("/dem", "time"), 0.5);
      return true;
    } catch (const InputError& error) {
      EXPECT_EQ(error.problems().size(), 1U);
      EXPECT_EQ(std::string(error.what()).rfind(path_ + ": ", 0), 0U) << error.what();
      return false;
    }
  }

  Scratch scratch_;
  std::string path_, whole_;
  std::mt19937_64 random_{11};
};

TEST_F(Damage, CutAnywhereIsRefused) {
  EXPECT_TRUE(reads(whole_));
  for (int i = 0; i < 200; ++i) {
    const std::size_t length = random_() % whole_.size();
    EXPECT_FALSE(reads(whole_.substr(0, length))) << length;
  }
  EXPECT_FALSE(reads(whole_.substr(0, whole_.size() - 1)));
}

TEST_F(Damage, FlippedBitsAreRefusedOrHarmless) {
  int refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = whole_;
    // Half of the errors in the first part, where the structure of the file is dense.
    const std::size_t at =
        random_() % (i % 2 == 0 ? std::min<std::size_t>(8192, bytes.size()) : bytes.size());
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random_() % 8)));
    refused += reads(bytes) ? 0 : 1;
  }
  EXPECT_GT(refused, 200);
}

TEST_F(Damage, ZeroedBlocksAreRefusedOrHarmless) {
  for (int i = 0; i < 100; ++i) {
    std::string bytes = whole_;
    const std::size_t at = random_() % bytes.size();
    bytes.replace(at, std::min<std::size_t>(512, bytes.size() - at), 512, '\0');
    bytes.resize(whole_.size());
    reads(bytes);
  }
}

}  // namespace
}  // namespace trackbed::io::checkpoint_damage_test
