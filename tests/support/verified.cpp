// One file per program and number of ranks, so that programs that run side by side do not mix rows:
// a row is folder, test, quantity, unit, measured, sign, reference or limit, tolerance, separated
// by tabs.
#include "support/verified.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "trackbed/par/comm.hpp"

namespace trackbed::verified {

namespace {

namespace fs = std::filesystem;

// Empty if no rows are requested, or on other ranks than 0.
std::ofstream opened() {
  const char* folder = std::getenv("TRACKBED_VERIFICATION");
  const par::Comm world = par::Comm::world();
  if (folder == nullptr || !world.root()) return {};
  fs::create_directories(folder);
  return std::ofstream(fs::path(folder) /
                       fmt::format("{}_{}.tsv", program_invocation_short_name, world.size()));
}

void keep(const std::string& quantity, const std::string& unit, double measured,
          const std::string& sign, double reference, double tolerance, const Place& place) {
  static std::ofstream rows = opened();
  if (!rows.is_open()) return;
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
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
