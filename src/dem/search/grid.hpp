// Cells that cover the domain, and the rank that owns each. The map is the same on every rank; a
// particle belongs to the rank that owns the cell of its (wrapped) centre.
//
// Particles of very different size are in cells of different size (hierarchical grid: Ogarko,
// Luding 2012, doi:10.1016/j.cpc.2011.12.019): level 0 holds all up to twice the median, each
// further level twice as large ones. A particle is compared with those of a level in the cells
// covered by its own reach, so that a few large ones do not raise the cost of all. Departing from
// the paper, levels follow the sizes present, and each pair is found from the side of one particle.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

using Cell = std::array<int, 3>;

// Equal boxes that fill the domain. Independent of particles and ranks.
class Lattice {
 public:
  struct Image {  // a position shifted into the domain
    Cell cell;
    Cell wrap;  // position + wrap * period is in the domain
  };

  Lattice() = default;
  // Edges no smaller than `edge`, m; not many more than `most` cells.
  Lattice(const Domain& domain, double edge, double most);

  Image locate(const Vec3& position) const;
  std::size_t size() const;
  // z runs fastest: neighbours in a low bed are mostly neighbours in memory.
  std::size_t index(const Cell& cell) const {
    return (static_cast<std::size_t>(cell[0]) * static_cast<std::size_t>(count_[1]) +
            static_cast<std::size_t>(cell[1])) *
               static_cast<std::size_t>(count_[2]) +
           static_cast<std::size_t>(cell[2]);
  }
  Cell cell(std::size_t index) const;
  Vec3 centre(std::size_t index) const;
  const Vec3& edge() const { return edge_; }  // m
  const Vec3& period() const { return extent_; }

  // Calls visit(cell, image) for the cells that intersect the box, until it returns true; returns
  // whether it did. image: periods to be added to the content of the cell to shift it into the box.
  // Points beyond a side that is not periodic belong to the last cell.
  template <class Visit>
  bool any(const Vec3& low, const Vec3& high, Visit&& visit) const {
    const Cell first = lowest(low, high), last = highest(low, high);
    Cell inside, image;
    const auto fold = [&](std::size_t a, int c) {
      image[a] = 0;
      if (c < 0 || c >= count_[a]) image[a] = (c < 0 ? c + 1 : c) / count_[a] - (c < 0 ? 1 : 0);
      inside[a] = c - image[a] * count_[a];
    };
    for (int x = first[0]; x <= last[0]; ++x) {
      fold(0, x);
      for (int y = first[1]; y <= last[1]; ++y) {
        fold(1, y);
        for (int z = first[2]; z <= last[2]; ++z) {
          fold(2, z);
          if (visit(inside, image)) return true;
        }
      }
    }
    return false;
  }
  // The same for all cells that intersect the cube of half side `reach` around a position in the
  // domain.
  template <class Visit>
  void around(const Vec3& position, double reach, Visit&& visit) const {
    any(position.array() - reach, position.array() + reach,
        [&](const Cell& cell, const Cell& image) { return visit(cell, image), false; });
  }

 private:
  Cell lowest(const Vec3& low, const Vec3& high) const;
  Cell highest(const Vec3& low, const Vec3& high) const;

  Domain domain_;
  Cell count_{1, 1, 1};
  Vec3 edge_ = Vec3::Ones(), extent_ = Vec3::Ones();
};

class Grid {
 public:
  struct Level {
    double bound = 0;  // m, largest bounding radius in it
    Lattice lattice;
  };

  Grid() = default;
  // `bounds`: the largest bounding radius (m) of each level, ascending, not empty; `particles`: of
  // all ranks. Throws InputError if a periodic side is shorter than 3 of the largest particles with
  // skin: two could then touch twice.
  Grid(const Domain& domain, std::span<const double> bounds, double skin, std::int64_t particles);

  const std::vector<Level>& levels() const { return levels_; }
  std::size_t level_of(double bound) const;
  double reach() const { return levels_.back().bound + skin_; }  // m, of any particle
  double skin() const { return skin_; }

  Lattice::Image locate(const Vec3& position) const { return levels_[0].lattice.locate(position); }
  // The position inside the domain.
  Vec3 wrapped(const Vec3& position, const Cell& wrap) const {
    return position + Vec3(wrap[0] * period(0), wrap[1] * period(1), wrap[2] * period(2));
  }
  // Beyond a side that is not periodic, or not a number.
  bool outside(const Vec3& position) const;
  double period(int axis) const { return levels_[0].lattice.period()[axis]; }
  const Vec3& edge() const { return levels_[0].lattice.edge(); }

  // Owners are those of the cells of level 0.
  std::size_t cells() const { return owner_.size(); }
  std::size_t cell_of(const Vec3& position) const {
    return levels_[0].lattice.index(locate(position).cell);
  }
  int owner(const Cell& cell) const { return owner_[levels_[0].lattice.index(cell)]; }
  int owner_at(const Vec3& position) const { return owner_[cell_of(position)]; }
  bool owns_part_of(const Vec3& low, const Vec3& high, int rank) const;
  // Partitions the cells such that the work (any unit; of each cell, the same on every rank) is
  // even and little of it is along cuts. Returns the work of the busiest rank over the mean.
  double partition(const std::vector<double>& work, int ranks);
  double worst(const std::vector<double>& work, int ranks) const;  // of the present partition

 private:
  void fill_empty_cells(const std::vector<std::size_t>& occupied);

  Domain domain_;
  double skin_ = 0;
  std::vector<Level> levels_{1};
  // Of each cell of level 0; every rank has the whole map.
  std::vector<int> owner_;
};

}  // namespace trackbed::dem
