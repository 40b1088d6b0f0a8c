// main of every test: MPI around GoogleTest; only rank 0 prints, failures of all ranks count.
//   unit_dem_tests [--file stones_test] [GoogleTest option...]   all tests, or those of a file
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "trackbed/par/comm.hpp"

namespace {

// Failures on ranks other than 0 still reach the log, each with its rank.
class OtherRankPrinter : public ::testing::EmptyTestEventListener {
 public:
  explicit OtherRankPrinter(int rank) : rank_(rank) {}
  void OnTestPartResult(const ::testing::TestPartResult& result) override {
    if (result.failed())
      std::fprintf(stderr, "[rank %d] %s:%d: %s\n", rank_, result.file_name(), result.line_number(),
                   result.message());
  }

 private:
  int rank_;
};

// A filter of GoogleTest for the tests of `file` (without folder and .cpp); empty if it has none.
std::string filter_of(const std::string& file) {
  std::string filter;
  const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const ::testing::TestSuite& suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const ::testing::TestInfo& test = *suite.GetTestInfo(t);
      if (std::filesystem::path(test.file()).stem() == file)
        filter += std::string(suite.name()) + "." + test.name() + ":";
    }
  }
  return filter;
}

}  // namespace

int main(int argc, char** argv) {
  const trackbed::par::Environment environment(argc, argv);
  ::testing::InitGoogleTest(&argc, argv);
  if (argc == 3 && argv[1] == std::string_view("--file")) {
    const std::string filter = filter_of(argv[2]);
    if (filter.empty()) {
      std::fprintf(stderr, "%s.cpp: contains no test of this program\n", argv[2]);
      return 2;
    }
    ::testing::GTEST_FLAG(filter) = filter;
  } else if (argc != 1) {
    std::fprintf(stderr, "usage: %s [--file NAME] [GoogleTest option...]\n", argv[0]);
    return 2;
  }
  const auto world = trackbed::par::Comm::world();
  if (!world.root()) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new OtherRankPrinter(world.rank()));
  }
  const int failed = RUN_ALL_TESTS();
  return static_cast<int>(world.max(static_cast<std::int64_t>(failed)));
}
