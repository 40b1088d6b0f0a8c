// One file per source file of tests and number of ranks, so that tests that run side by side do not
// mix rows. A row is folder, test, quantity, unit, measured, sign, reference or limit, tolerance,
// separated by tabs.
#include "support/verified.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

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

void keep(const std::string& quantity, const std::string& unit, double measured,
          const std::string& sign, double reference, double tolerance, const Place& place) {
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
  static std::map<std::string, std::ofstream> files;
  const std::string source = fs::path(test.file()).stem();
  if (!files.contains(source)) files[source] = opened(source);
  std::ofstream& rows = files[source];
  if (!rows.is_open()) return;
  rows << fmt::format("{}\t{}.{}\t{}\t{}\t{:.15g}\t{}\t{:.9g}\t{:.3g}\n",
                      fs::path(place.file_name()).parent_path().filename().string(),
                      test.test_suite_name(), test.name(), quantity, unit, measured, sign,
                      reference, tolerance)
       << std::flush;
}

}  // namespace

void near(const std::string& quantity, const std::string& unit, double measured, double reference,
          double tolerance, const Place& place) {
  keep(quantity, unit, measured, "=", reference, tolerance, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_NEAR(measured, reference, tolerance);
}

void below(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place) {
  keep(quantity, unit, measured, "<", limit, 0, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_LT(measured, limit);
}

void above(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place) {
  keep(quantity, unit, measured, ">", limit, 0, place);
  const ::testing::ScopedTrace trace(place.file_name(), static_cast<int>(place.line()), quantity);
  EXPECT_GT(measured, limit);
}

}  // namespace trackbed::verified
