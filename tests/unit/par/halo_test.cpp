// Forward and backward transfer of chosen items between all ranks.
#include "trackbed/par/halo.hpp"

#include <gtest/gtest.h>

namespace trackbed::par::halo_test {
namespace {

struct Item {
  int rank;
  double value;
  bool operator==(const Item&) const = default;
};

// Rank r sends items 0 .. (r + to) % 3 - 1 to every other rank, the last one first.
std::vector<std::int32_t> sent(int from, int to) {
  std::vector<std::int32_t> items;
  for (std::int32_t k = (from + to) % 3; k-- > 0;) items.push_back(k);
  return from == to ? std::vector<std::int32_t>{} : items;
}

class HaloOfAll : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::vector<std::int32_t>> lists;
    for (int to = 0; to < comm_.size(); ++to) lists.push_back(sent(comm_.rank(), to));
    halo_.connect(comm_, lists);
  }
  Comm comm_ = Comm::world();
  Halo halo_;
};

TEST_F(HaloOfAll, ForwardArrivesByRankInTheOrderOfTheSender) {
  std::vector<Item> data, expected;
  for (int k = 0; k < 3; ++k) data.push_back({comm_.rank(), 0.25 * k});
  for (int from = 0; from < comm_.size(); ++from)
    for (const std::int32_t k : sent(from, comm_.rank())) expected.push_back({from, 0.25 * k});
  ASSERT_EQ(halo_.received(), expected.size());
  std::vector<Item> ghosts(halo_.received());
  halo_.forward(data.data(), ghosts.data());
  EXPECT_EQ(ghosts, expected);
}

TEST_F(HaloOfAll, BackwardReturnsToTheItemsThatWereSent) {
  std::vector<int> data{10, 20, 30}, ghosts(halo_.received());
  for (int& value : data) value += comm_.rank();
  halo_.forward(data.data(), ghosts.data());
  for (int& value : ghosts) value *= 2;
  std::vector<int> returned(halo_.sent());
  halo_.backward(ghosts.data(), returned.data());
  for (std::size_t k = 0; k < returned.size(); ++k)
    EXPECT_EQ(returned[k], 2 * data[static_cast<std::size_t>(halo_.items()[k])]);
}

TEST_F(HaloOfAll, WithoutItemsNothingIsSent) {
  Halo none;
  none.connect(comm_,
               std::vector<std::vector<std::int32_t>>(static_cast<std::size_t>(comm_.size())));
  EXPECT_EQ(none.sent() + none.received(), 0u);
  none.forward<int>(nullptr, nullptr);
}

}  // namespace
}  // namespace trackbed::par::halo_test
