// main of every test: MPI around GoogleTest; only rank 0 prints, failures of all ranks count.
#include <gtest/gtest.h>

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

}  // namespace

int main(int argc, char** argv) {
  const trackbed::par::Environment environment(argc, argv);
  ::testing::InitGoogleTest(&argc, argv);
  const auto world = trackbed::par::Comm::world();
  if (!world.root()) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new OtherRankPrinter(world.rank()));
  }
  const int failed = RUN_ALL_TESTS();
  return static_cast<int>(world.max(static_cast<std::int64_t>(failed)));
}
