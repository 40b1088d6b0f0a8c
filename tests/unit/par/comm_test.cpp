// Collective operations against what they must give on any number of ranks.
#include "trackbed/par/comm.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <thread>

#include "trackbed/core/error.hpp"
#include "trackbed/par/exact_totals.hpp"
#include "trackbed/par/meeting.hpp"

namespace trackbed::par::comm_test {
namespace {

// Different on each rank, and without order: 0 -1 2 -3 ...
std::int64_t mine(const Comm& comm) { return comm.rank() % 2 == 0 ? comm.rank() : -comm.rank(); }

TEST(Comm, ReducesOverAllRanks) {
  const Comm comm = Comm::world();
  std::int64_t sum = 0, least = 0, most = 0;
  for (int r = 0; r < comm.size(); ++r) {
    const std::int64_t value = r % 2 == 0 ? r : -r;
    sum += value, least = std::min(least, value), most = std::max(most, value);
  }
  EXPECT_EQ(comm.sum(mine(comm)), sum);
  EXPECT_EQ(comm.max(mine(comm)), most);
  EXPECT_EQ(comm.sum(0.5 * static_cast<double>(mine(comm))), 0.5 * static_cast<double>(sum));
  EXPECT_EQ(comm.min(static_cast<double>(mine(comm))), static_cast<double>(least));
  EXPECT_EQ(comm.max(static_cast<double>(mine(comm))), static_cast<double>(most));
}

TEST(Comm, ReducesListsInPlace) {
  const Comm comm = Comm::world();
  std::vector<std::int64_t> counts{1, mine(comm)};
  comm.sum(std::span(counts));
  EXPECT_EQ(counts, (std::vector<std::int64_t>{comm.size(), comm.sum(mine(comm))}));
  std::vector<double> largest{-1.0 - comm.rank(), 2.0 * comm.rank()};
  comm.max(std::span(largest));
  EXPECT_EQ(largest, (std::vector<double>{-1, 2.0 * (comm.size() - 1)}));
}

TEST(Comm, ScansOverLowerRanks) {
  const Comm comm = Comm::world();
  EXPECT_EQ(comm.exclusive_scan(comm.rank() + 1), comm.rank() * (comm.rank() + 1) / 2);
}

// Rank r has r items: one rank has none.
TEST(Comm, GathersInRankOrder) {
  const Comm comm = Comm::world();
  const std::vector<double> own(static_cast<std::size_t>(comm.rank()), comm.rank() + 0.5);
  std::vector<double> expected;
  for (int r = 0; r < comm.size(); ++r)
    expected.insert(expected.end(), static_cast<std::size_t>(r), r + 0.5);
  EXPECT_EQ(comm.all_gather(std::span(own)), expected);
}

TEST(Comm, ExchangesListsOfAnyLength) {
  const Comm comm = Comm::world();
  const auto list = [](int from, int to) {
    std::vector<std::int32_t> items(static_cast<std::size_t>((2 * from + to) % 3));
    std::iota(items.begin(), items.end(), 100 * from + 10 * to);
    return items;
  };
  std::vector<std::vector<std::int32_t>> out, expected;
  for (int r = 0; r < comm.size(); ++r)
    out.push_back(list(comm.rank(), r)), expected.push_back(list(r, comm.rank()));
  EXPECT_EQ(comm.exchange(out), expected);
}

TEST(Comm, BroadcastsTheTextOfRankZero) {
  const Comm comm = Comm::world();
  EXPECT_EQ(comm.broadcast(comm.root() ? "text with \n a break" : "other"), "text with \n a break");
  EXPECT_EQ(comm.broadcast(comm.root() ? "" : "other"), "");
}

TEST(Comm, AgreesOnTheProblemOfTheLowestRank) {
  const Comm comm = Comm::world();
  EXPECT_NO_THROW(comm.agree(""));
  EXPECT_EQ(comm.first_problem(""), "");
  const int last = comm.size() - 1;
  const std::string problem = comm.rank() >= last ? "lost" : "";
  EXPECT_EQ(comm.first_problem(problem), "lost");
  try {
    comm.agree(problem);
    FAIL() << "every rank must throw";
  } catch (const RunError& error) {
    EXPECT_EQ(std::string(error.what()), "rank " + std::to_string(last) + ": lost");
  }
}

// Bitwise identical for any split of the terms, of which one is 1e16 times the others.
TEST(ExactTotals, DoNotDependOnTheRanks) {
  const Comm comm = Comm::world();
  constexpr std::size_t all = 37;
  const auto value = [](std::size_t k) { return k == 5 ? 1e16 : 1.0 / static_cast<double>(k + 1); };
  std::vector<std::size_t> own;
  for (std::size_t k = 0; k < all; ++k)
    if (k % static_cast<std::size_t>(comm.size()) == static_cast<std::size_t>(comm.rank()))
      own.push_back(k);
  const auto total = exact_totals(comm, {}, own.size(), [&](std::size_t k) {
    return ExactTerm{0, value(own[k])};
  });
  const auto alone = exact_totals(Comm::self(), {}, all, [&](std::size_t k) {
    return ExactTerm{0, value(k)};
  });
  EXPECT_EQ(total, alone);
}

TEST(Meeting, ReportsARankThatDoesNotArrive) {
  const Comm comm = Comm::world();
  {
    Meeting all(comm);
    EXPECT_TRUE(all.all_arrive(30));
  }
  if (comm.size() == 1) return;
  Meeting late(comm);
  using namespace std::chrono_literals;
  if (comm.root()) {
    std::this_thread::sleep_for(300ms);
    late.all_arrive(30);
  } else {
    EXPECT_FALSE(late.all_arrive(0.02));
  }
}

}  // namespace
}  // namespace trackbed::par::comm_test
