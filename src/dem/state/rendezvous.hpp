// Records of a file, each read by one rank, are sent to the ranks that hold the particles they
// name. No rank knows where all particles are: rank `id mod ranks` knows the holder of a particle,
// and forwards the records that name it. A rank holds several times 1/ranks of all records while
// they are sent, as most are sent twice.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "trackbed/dem/particles.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::dem {

// Calls `named(record)` for the two ids of a record; an id below 0 names no particle. Returns the
// records that name a particle in `held`, each once, sorted; those that name unknown particles
// alone are dropped. Collective.
template <class Record, class Named>
std::vector<Record> delivered(const par::Comm& comm, std::span<const Id> held,
                              const std::vector<Record>& records, Named named) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  const auto knows = [&](Id id) { return static_cast<std::size_t>(id) % ranks; };
  std::vector<std::vector<Id>> holds(ranks);
  for (const Id id : held) holds[knows(id)].push_back(id);
  std::unordered_map<Id, std::size_t> holder;
  const auto sent = comm.exchange(holds);
  for (std::size_t rank = 0; rank < ranks; ++rank)
    for (const Id id : sent[rank]) holder[id] = rank;
  // Once to each of the ranks that know the holders, and from there once to each holder.
  const auto send = [&](const std::vector<Record>& some, auto where) {
    std::vector<std::vector<Record>> out(ranks);
    for (const Record& record : some) {
      std::array<std::ptrdiff_t, 2> to{-1, -1};
      const std::array<Id, 2> ids = named(record);
      for (std::size_t k = 0; k < 2; ++k)
        if (ids[k] >= 0) to[k] = where(ids[k]);
      if (to[0] >= 0) out[static_cast<std::size_t>(to[0])].push_back(record);
      if (to[1] >= 0 && to[1] != to[0]) out[static_cast<std::size_t>(to[1])].push_back(record);
    }
    std::vector<Record> in;
    for (const auto& list : comm.exchange(out)) in.insert(in.end(), list.begin(), list.end());
    return in;
  };
  const auto found = send(records, [&](Id id) { return static_cast<std::ptrdiff_t>(knows(id)); });
  std::vector<Record> mine = send(found, [&](Id id) -> std::ptrdiff_t {
    const auto at = holder.find(id);  // of the other id another rank knows the holder
    return at == holder.end() ? -1 : static_cast<std::ptrdiff_t>(at->second);
  });
  std::sort(mine.begin(), mine.end());
  const auto same = [](const Record& a, const Record& b) { return !(a < b) && !(b < a); };
  mine.erase(std::unique(mine.begin(), mine.end(), same), mine.end());
  return mine;
}

}  // namespace trackbed::dem
