// Numbers of ranks and processors of a node.
#include "trackbed/par/processors.hpp"

#include <gtest/gtest.h>
#include <sched.h>

namespace trackbed::par::processors_test {
namespace {

// Restores the affinity of the process.
class Bound {
 public:
  explicit Bound(int processor) {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(processor, &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  ~Bound() { sched_setaffinity(0, sizeof before_, &before_); }
  Bound(const Bound&) = delete;

 private:
  cpu_set_t before_;
};

int first_processor() {
  cpu_set_t set;
  sched_getaffinity(0, sizeof set, &set);
  int k = 0;
  while (!CPU_ISSET(k, &set)) ++k;
  return k;
}

TEST(Processors, AreThoseOfAllRanksOfTheNode) {
  const Comm world = Comm::world();
  const Processors all = processors_of(world);
  EXPECT_EQ(all.ranks, world.size());  // the tests run on one node
  EXPECT_GE(all.processors, 1);
  EXPECT_EQ(all.too_few(), world.size() > all.processors);
}

TEST(Processors, OneIsTooFewForSeveralRanks) {
  const Comm world = Comm::world();
  const Bound bound(static_cast<int>(world.max(std::int64_t{first_processor()})));
  const Processors one = processors_of(world);
  EXPECT_EQ(one.processors, 1);
  EXPECT_EQ(one.too_few(), world.size() > 1);
}

}  // namespace
}  // namespace trackbed::par::processors_test
