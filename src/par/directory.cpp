#include "trackbed/par/directory.hpp"

#include <algorithm>

#include "trackbed/core/error.hpp"

namespace trackbed::par {

Directory::Directory(const Comm& comm, std::span<const std::int64_t> numbers,
                     std::span<const std::int64_t> places)
    : comm_(comm) {
  require(numbers.size() == places.size(), "one place for each number");
  std::vector<std::vector<Entry>> out(static_cast<std::size_t>(comm.size()));
  for (std::size_t k = 0; k < numbers.size(); ++k)
    out[keeper(numbers[k])].push_back({numbers[k], places[k]});
  for (const auto& list : comm.exchange(out))
    entries_.insert(entries_.end(), list.begin(), list.end());
  std::sort(entries_.begin(), entries_.end());
}

std::vector<std::int64_t> Directory::places_of(std::span<const std::int64_t> wanted) const {
  std::vector<std::vector<std::int64_t>> asked(static_cast<std::size_t>(comm_.size()));
  for (const std::int64_t number : wanted) asked[keeper(number)].push_back(number);
  auto answers = comm_.exchange(asked);
  for (auto& list : answers)
    for (std::int64_t& number : list) {
      const auto at = std::lower_bound(entries_.begin(), entries_.end(), Entry{number, 0});
      number = at != entries_.end() && at->number == number ? at->place : -1;
    }
  answers = comm_.exchange(answers);
  std::vector<std::int64_t> found;
  std::vector<std::size_t> next(answers.size(), 0);
  for (const std::int64_t number : wanted) {
    const std::size_t rank = keeper(number);
    found.push_back(answers[rank][next[rank]++]);
  }
  return found;
}

}  // namespace trackbed::par
