// Partition of the elements of a lattice into boxes of even cost, one for each rank: the longest
// side of a box, counted in elements, is cut between two layers until each rank has its box
// (recursive bisection: Berger, Bokhari 1987, doi:10.1109/TC.1987.1676942). Every rank keeps the
// cuts, a few numbers for each rank, and finds the box of any element from them.
#pragma once

#include <functional>
#include <vector>

#include "fem/mesh/lattice.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

struct IndexBox {
  Index3 begin{}, end{};  // elements of [begin, end)
  std::int64_t size() const {
    return (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
  }
};

class Boxes {
 public:
  // `cost` of an element, any unit, > 0; rounded to a thousandth. Each element is visited once for
  // each halving, by one rank. A box of fewer elements than ranks leaves some of them without any.
  // The same on every rank. Collective.
  Boxes(const par::Comm& comm, const Index3& elements,
        const std::function<double(const Index3&)>& cost);
  int rank_of(const Index3& element) const;
  const IndexBox& box_of(int rank) const { return boxes_[static_cast<std::size_t>(rank)]; }

 private:
  // Ranks [first, first + ranks) share a box; below `cut` along `axis` the first half of them.
  struct Part {
    IndexBox box;
    int first, ranks;
    std::size_t axis = 0;
    std::int64_t cut = 0;
    std::size_t lower = 0;  // number of the part below the cut; the one above follows it
  };
  void cut_all(std::size_t from, const par::Comm& comm,
               const std::function<double(const Index3&)>& cost);

  std::vector<Part> parts_;
  std::vector<IndexBox> boxes_;
};

}  // namespace trackbed::fem
