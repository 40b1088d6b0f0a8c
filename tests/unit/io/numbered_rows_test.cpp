// Rows reach the ranks that want them, in the order in which they want them.
#include "trackbed/io/numbered_rows.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::io::numbered_rows_test {
namespace {

par::Comm world() { return par::Comm::world(); }
constexpr std::int64_t total = 1000;
double value(std::int64_t number, int column) { return 0.5 * static_cast<double>(number) - column; }

// Numbers 3 k in steps of 21 modulo 3000, unevenly split.
void write(const std::string& path) {
  std::vector<std::int64_t> numbers;
  std::vector<double> values;
  const std::int64_t parts = world().size() * (world().size() + 1) / 2;
  const auto end = [&](int rank) { return total * rank * (rank + 1) / 2 / parts; };
  for (std::int64_t k = end(world().rank()); k < end(world().rank() + 1); ++k) {
    numbers.push_back(3 * (7 * k % total));
    for (int c = 0; c < 2; ++c) values.push_back(value(numbers.back(), c));
  }
  File file(world(), path, Mode::create);
  file.write<std::int64_t>("/ground/node", numbers, 1, {"-", "number"});
  file.write<double>("/ground/u", values, 2, {"m", "a test's numbers"});
  file.close();
}

TEST(NumberedRows, ReachEveryRankThatWantsThem) {
  const Scratch scratch("numbered_rows");
  write(scratch / "a.h5");
  const File file(world(), scratch / "a.h5", Mode::read);
  // A third of all, by a hash, of which some are wanted on several ranks; the last rank wants none.
  std::vector<std::int64_t> wanted;
  const bool last = world().size() > 1 && world().rank() + 1 == world().size();
  for (std::int64_t k = total; k-- > 0;)
    if (!last && mix(static_cast<std::uint64_t>(k * 8 + world().rank())) % 3 == 0)
      wanted.push_back(3 * k);
  const NumberedRows rows(world(), file, "/ground/node", wanted);
  const auto values = rows.read("/ground/u", 2);
  ASSERT_EQ(values.size(), 2 * wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k)
    for (int c = 0; c < 2; ++c)
      EXPECT_EQ(values[2 * k + static_cast<std::size_t>(c)], value(wanted[k], c));
}

TEST(NumberedRows, NameTheRowThatIsMissing) {
  const Scratch scratch("missing_rows");
  write(scratch / "a.h5");
  const File file(world(), scratch / "a.h5", Mode::read);
  std::vector<std::int64_t> wanted{3};
  if (world().root()) wanted.push_back(10);
  try {
    const NumberedRows rows(world(), file, "/ground/node", wanted);
    FAIL() << "row 10 does not exist";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("/ground/node of the checkpoint has no row 10;"),
              std::string::npos)
        << error.what();
  }
}

// A rank that reads all by itself, from a file that all have opened.
TEST(NumberedRows, CanBeReadByEachRankAlone) {
  const Scratch scratch("rows_alone");
  write(scratch / "a.h5");
  const File file(world(), scratch / "a.h5", Mode::read);
  std::vector<std::int64_t> wanted;
  for (std::int64_t k = 0; k < total; ++k) wanted.push_back(3 * k);
  const NumberedRows rows(par::Comm::self(), file, "/ground/node", wanted);
  const auto values = rows.read("/ground/u", 2);
  for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_EQ(values[2 * k], value(wanted[k], 0));
}

TEST(NumberedRows, RefuseDatasetsOfAnotherShape) {
  const Scratch scratch("shaped_rows");
  write(scratch / "a.h5");
  const File file(world(), scratch / "a.h5", Mode::read);
  const NumberedRows rows(world(), file, "/ground/node", std::vector<std::int64_t>{3});
  EXPECT_THROW(rows.read("/ground/u", 3), RunError);
}

}  // namespace
}  // namespace trackbed::io::numbered_rows_test
