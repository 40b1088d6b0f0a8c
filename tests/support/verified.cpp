// One file per source file of tests and number of ranks, so that tests that run side by side do not
// mix rows. A row is folder, test, quantity, unit, measured, sign, reference or limit, tolerance,
// reason, separated by tabs.
#include "support/verified.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <type_traits>

#include "trackbed/par/comm.hpp"

namespace trackbed::verified {

namespace {

namespace fs = std::filesystem;

// Empty if no rows are requested, or on other ranks than 0.
std::ofstream opened(const std::string& source) {
  const char* folder = std::getenv("TRACKBED_VERIFICATION");
  const par::Comm world = par::Comm::world();
  if (folder == nullptr || !world.root()) return {};
  fs::create_directories(folder);
  return std::ofstream(fs::path(folder) / fmt::format("{}_{}.tsv", source, world.size()));
}

static_assert(std::is_constructible_v<Reason, const char (&)[2]> &&
              !std::is_constructible_v<Reason, const char (&)[1]>);  // an empty text
static_assert(!std::is_convertible_v<double, Tolerance>);            // no tolerance without reason

struct Row {
  const std::string &quantity, &unit;
  double measured, reference, tolerance;
  const char *sign, *reason;
};

void keep(const Row& row, const Place& place) {
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
  static std::map<std::string, std::ofstream> files;
  const std::string source = fs::path(test.file()).stem();
  if (!files.contains(source)) files[source] = opened(source);
  std::ofstream& rows = files[source];
  if (!rows.is_open()) return;
  rows << fmt::format("{}\t{}.{}\t{}\t{}\t{:.15g}\t{}\t{:.15g}\t{:.3g}\t{}\n",
                      fs::path(place.file_name()).parent_path().filename().string(),
                      test.test_suite_name(), test.name(), row.quantity, row.unit, row.measured,
                      row.sign, row.reference, row.tolerance, row.reason)
       << std::flush;
}

}  // namespace

void near(const std::string& quantity, const std::string& unit, double measured, double reference,
          const Tolerance& tolerance, const Place& place) {
  keep({quantity, unit, measured, reference, tolerance.size, "=", tolerance.reason.text()}, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_NEAR(measured, reference, tolerance.size);
}

void below(const std::string& quantity, const std::string& unit, double measured,
           const Limit& limit, const Place& place) {
  keep({quantity, unit, measured, limit.size, 0, "<", limit.reason.text()}, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_LT(measured, limit.size);
}

void above(const std::string& quantity, const std::string& unit, double measured,
           const Limit& limit, const Place& place) {
  keep({quantity, unit, measured, limit.size, 0, ">", limit.reason.text()}, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_GT(measured, limit.size);
}

}  // namespace trackbed::verified
