// Where things are that are distributed over the ranks and known by a number.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

// A place, an integer of 0 or more, for each number. No rank knows all of them: rank `number mod
// ranks` does, and is asked; so memory and messages of a rank are those of the numbers it gives and
// asks for. All calls are collective.
class Directory {
 public:
  // `numbers`, of 0 or more, and their `places` as known to this rank. Of several places of a
  // number the least one counts, on any number of ranks.
  Directory(const Comm& comm, std::span<const std::int64_t> numbers,
            std::span<const std::int64_t> places);
  // Of each wanted number, -1 if nobody has given it. Several ranks may ask for the same.
  std::vector<std::int64_t> places_of(std::span<const std::int64_t> wanted) const;

 private:
  struct Entry {
    std::int64_t number, place;
    auto operator<=>(const Entry&) const = default;
  };
  std::size_t keeper(std::int64_t number) const {
    return static_cast<std::size_t>(number) % static_cast<std::size_t>(comm_.size());
  }

  Comm comm_;
  std::vector<Entry> entries_;  // those that this rank keeps, by number
};

}  // namespace trackbed::par
