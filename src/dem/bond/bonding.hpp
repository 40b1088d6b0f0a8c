// State of bonds. Operations: dem/particles/bonds.cpp; checkpoint: bonds_file.cpp there.
#pragma once

#include <vector>

#include "dem/bond/bond.hpp"

namespace trackbed::dem {

struct Bonding {
  std::vector<BondParameters> parameters;  // not part of the state
  // State: of own stones, by ids; how many were ever made; what broke, by this rank.
  std::vector<Bond> bonds;
  std::int64_t made = 0;
  std::vector<BondBreak> breaks;
  double longest = 0;  // m, of what bonds reach beyond the balls around both stones; only grows
  // Whether attitudes of balls matter, on all ranks alike.
  bool any = false;
  // Derived, of each bond: numbers of its stones on this rank, image of the second one.
  struct Place {
    std::size_t i, j;
    Vec3 shift;  // m, added to the position of j
  };
  std::vector<Place> places;
};

}  // namespace trackbed::dem
