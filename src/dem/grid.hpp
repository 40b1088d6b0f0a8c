// Cells that cover the domain, and which rank owns each. The map is the same on every rank; a
// particle belongs to the rank that owns the cell its (wrapped) centre lies in.
#pragma once

#include <array>
#include <vector>

#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

class Grid {
 public:
  struct Image {  // a position brought into the domain
    std::array<int, 3> cell;
    std::array<int, 3> wrap;  // position + wrap * period lies in the domain
  };

  Grid() = default;
  // Cells no smaller than `edge`. Throws InputError if a periodic side has fewer than 3 of them:
  // two particles could then touch twice.
  Grid(const Domain& domain, double edge);

  Image locate(const Vec3& position) const;
  // Beyond a side that is not periodic, or not a number.
  bool outside(const Vec3& position) const;
  std::size_t index(const std::array<int, 3>& cell) const {
    return (static_cast<std::size_t>(cell[0]) * static_cast<std::size_t>(count_[1]) +
            static_cast<std::size_t>(cell[1])) *
               static_cast<std::size_t>(count_[2]) +
           static_cast<std::size_t>(cell[2]);
  }
  std::size_t cells() const { return owner_.size(); }
  double period(int axis) const { return extent_[axis]; }
  int owner(std::size_t cell) const { return owner_[cell]; }
  // Even split of the particles counted per cell (`weights`, the same on every rank).
  void share_out(const std::vector<double>& weights, int ranks);

  // Calls see(cell index, image) for the up to 27 cells around; image[a] is -1, 0 or 1 where the
  // neighbour lies across a periodic side. Cells beyond other sides are left out.
  template <class See>
  void around(const std::array<int, 3>& cell, See&& see) const {
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          std::array<int, 3> other{cell[0] + dx, cell[1] + dy, cell[2] + dz}, image{};
          if (reachable(other, image)) see(index(other), image);
        }
  }
  Vec3 low_of(std::size_t cell) const;
  const Vec3& edge() const { return edge_; }

 private:
  bool reachable(std::array<int, 3>& cell, std::array<int, 3>& image) const;

  Domain domain_;
  std::array<int, 3> count_{1, 1, 1};
  Vec3 edge_ = Vec3::Ones(), extent_ = Vec3::Ones();
  std::vector<int> owner_;
};

}  // namespace trackbed::dem
