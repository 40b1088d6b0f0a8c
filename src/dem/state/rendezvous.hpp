// Records of a file, each read by one rank, are sent to the ranks that hold the particles they
// name.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "trackbed/dem/particles.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/par/directory.hpp"

namespace trackbed::dem {

// Calls `named(record)` for the two ids of a record; an id below 0 names no particle. Returns the
// records that name a particle in `held`, each once, sorted; those that name unknown particles
// alone are dropped. Collective.
template <class Record, class Named>
std::vector<Record> delivered(const par::Comm& comm, std::span<const Id> held,
                              const std::vector<Record>& records, Named named) {
  const std::vector<std::int64_t> here(held.size(), comm.rank());
  std::vector<Id> ids;
  for (const Record& record : records)
    for (const Id id : named(record))
      if (id >= 0) ids.push_back(id);
  const auto holders = par::Directory(comm, held, here).places_of(ids);
  std::vector<std::vector<Record>> out(static_cast<std::size_t>(comm.size()));
  auto holder = holders.begin();
  for (const Record& record : records) {
    std::array<std::int64_t, 2> to{-1, -1};
    const std::array<Id, 2> both = named(record);
    for (std::size_t k = 0; k < 2; ++k)
      if (both[k] >= 0) to[k] = *holder++;
    if (to[0] >= 0) out[static_cast<std::size_t>(to[0])].push_back(record);
    if (to[1] >= 0 && to[1] != to[0]) out[static_cast<std::size_t>(to[1])].push_back(record);
  }
  std::vector<Record> mine;
  for (const auto& list : comm.exchange(out)) mine.insert(mine.end(), list.begin(), list.end());
  std::sort(mine.begin(), mine.end());
  const auto same = [](const Record& a, const Record& b) { return !(a < b) && !(b < a); };
  mine.erase(std::unique(mine.begin(), mine.end(), same), mine.end());
  return mine;
}

}  // namespace trackbed::dem
