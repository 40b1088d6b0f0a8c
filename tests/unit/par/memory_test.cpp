// Memory of a machine, and models that need more.
#include "trackbed/par/memory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "trackbed/core/error.hpp"
#include "trackbed/par/processors.hpp"

namespace trackbed::par::memory_test {
namespace {

TEST(Memory, OfARankIsAPartOfTheNode) {
  const Comm comm = Comm::world();
  const double physical =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  EXPECT_EQ(ranks_on_node(comm), comm.size());
  EXPECT_GT(memory_of_rank(comm), 0);
  EXPECT_LE(memory_of_rank(comm) * comm.size(), physical);
}

TEST(Memory, AModelThatNeedsMoreIsRefused) {
  const Comm comm = Comm::world();
  const double has = memory_of_rank(comm);
  EXPECT_NO_THROW(require_memory(comm, 0.9 * has, "the bed has 1e+06 stones", "use fewer"));
  try {
    require_memory(comm, 1e15, "the bed has 1e+12 stones", "use fewer");
    FAIL() << "is accepted";
  } catch (const InputError& refused) {
    const std::string words = refused.what();
    EXPECT_NE(words.find("the bed has 1e+12 stones and needs at least 1e+06 GB"), words.npos);
    EXPECT_NE(words.find("use fewer"), words.npos);
  }
}

}  // namespace
}  // namespace trackbed::par::memory_test
