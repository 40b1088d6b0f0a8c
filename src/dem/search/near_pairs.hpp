// Pairs of balls that may touch before any particle has moved by a margin: blocks of eight with
// their history in lanes. They are taken from the neighbour list, in its order, far less often than
// each sub-step and far more often than that list is rebuilt; a sub-step then loops over few pairs
// and neither scans the list nor gathers histories from it. The choice of near pairs does not
// affect results: pairs that do not touch add zero, and each particle adds its contacts in the
// order of the list.
//
// Cost: a block is 640 bytes; beds of spheres at rest have about 1.2 near pairs per contact.
#pragma once

#include <vector>

#include "dem/lanes/lanes.hpp"
#include "dem/search/pairs.hpp"

namespace trackbed::dem {

struct alignas(64) PairBlock {
  std::int32_t i[lanes], j[lanes];  // pieces
  std::int32_t shift[lanes];        // number of the periodic shift
  std::uint32_t entry[lanes];       // in the list
  std::uint8_t law[lanes];
  Lanes root_mass;  // kg^0.5, of the effective mass
  Lanes ri, rj;     // m
  Lanes3 xi;        // m, history
  Mask touches;     // in the last sub-step
};

class NearPairs {
 public:
  // `x`: centres and radii of all pieces, `body` their particles; takes pairs closer than the
  // margin and all pairs that are not both slow. Histories are those of the list, to which those of
  // the previous near pairs must have been stored.
  // `limits`: of breakage; null: nothing breaks.
  struct Limits {
    const std::vector<double>& strength;  // N, of each piece
    const LawTable& laws;
  };
  void gather(const std::vector<Vec4>& x, const std::vector<std::int32_t>& body,
              const PairList& list, const Limits* limits = nullptr);
  void store(PairList& list) const;  // histories, and which entries touch
  // Calls visit(piece, entry, xi, roll) for the pairs that touch, in the order of the list; `roll`
  // is zero if no law resists rolling.
  template <class Visit>
  void visit_touching(Visit&& visit) const {
    for (std::size_t n = 0; n < blocks.size(); ++n) {
      const PairBlock& b = blocks[n];
      if (!any(b.touches)) continue;
      for (std::size_t k = 0; k < lanes; ++k)
        if (b.touches[k] != 0)
          visit(b.i[k], b.entry[k], Vec4{b.xi.x[k], b.xi.y[k], b.xi.z[k], b.root_mass[k]},
                roll.empty() ? Vec4{} : Vec4{roll[n].x[k], roll[n].y[k], roll[n].z[k], 0});
    }
  }
  void clear() { blocks.clear(), size.clear(), roll.clear(), limit.clear(), count = 0; }

  std::vector<PairBlock> blocks;
  std::vector<Lanes> size;        // m, `size` of History; empty if no law is Hertz's
  std::vector<Lanes3> roll;       // m, history; empty if no law resists rolling
  std::vector<Lanes> limit;       // m, overlap at which a piece breaks off; empty if nothing breaks
  std::vector<std::size_t> over;  // blocks in which one was exceeded in the last sub-step
  std::vector<Vec4> shifts;       // m, of the list, and one far away for lanes without a pair
  // Set before pairs are gathered:
  double margin = 0;         // m
  std::vector<double> slow;  // 1 or 0, of each particle
  std::size_t count = 0;     // pairs
  bool one_law = true;       // all pairs have the law of the first

 private:
  void put(std::size_t lane, std::int32_t piece, std::uint32_t e, const std::vector<Vec4>& x,
           const PairList& list);
  void find_limits(const Limits& limits);
  void fill_last(const std::vector<Vec4>& x, const PairList& list);
};

}  // namespace trackbed::dem
