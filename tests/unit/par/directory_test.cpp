// Places of numbers, asked for on other ranks than those that give them.
#include "trackbed/par/directory.hpp"

#include <gtest/gtest.h>

#include "trackbed/core/hash.hpp"

namespace trackbed::par::directory_test {
namespace {

constexpr std::int64_t total = 2000;
std::int64_t place_of(std::int64_t number) { return 7 * number + 1; }

// Every third number, given by a rank that a hash decides.
TEST(Directory, TellsEveryRankThePlaces) {
  const Comm world = Comm::world();
  std::vector<std::int64_t> numbers, places;
  const auto ranks = static_cast<std::uint64_t>(world.size());
  for (std::int64_t k = 0; k < total; k += 3)
    if (mix(static_cast<std::uint64_t>(k)) % ranks == static_cast<std::uint64_t>(world.rank()))
      numbers.push_back(k), places.push_back(place_of(k));
  const Directory directory(world, numbers, places);
  std::vector<std::int64_t> wanted;
  const bool asks = world.rank() > 0 || world.size() == 1;  // a rank may ask for none
  for (std::int64_t k = total + 5; asks && k-- > 0;)
    if (mix(static_cast<std::uint64_t>(8 * k + world.rank())) % 2 == 0) wanted.push_back(k);
  if (asks) wanted.push_back(wanted.front());
  const auto found = directory.places_of(wanted);
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k)
    EXPECT_EQ(found[k], wanted[k] < total && wanted[k] % 3 == 0 ? place_of(wanted[k]) : -1);
}

TEST(Directory, TakesTheLeastOfSeveralPlaces) {
  const std::vector<std::int64_t> numbers{4, 4}, wanted{4};
  const std::int64_t mine = 10 + Comm::world().rank();
  const std::vector<std::int64_t> places{mine + 5, mine};
  EXPECT_EQ(Directory(Comm::world(), numbers, places).places_of(wanted)[0], 10);
}

TEST(Directory, MayBeEmpty) {
  const Directory directory(Comm::world(), {}, {});
  const std::vector<std::int64_t> wanted{0, 5};
  EXPECT_EQ(directory.places_of(wanted), std::vector<std::int64_t>({-1, -1}));
}

}  // namespace
}  // namespace trackbed::par::directory_test
