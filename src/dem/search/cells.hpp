// Local particles sorted into the cells of their levels, in the box that they fill: memory and time
// follow the rank's particles, not the domain.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "dem/search/grid.hpp"
#include "dem/state/state.hpp"

namespace trackbed::dem {

// A snapshot, made for a rebuild and dropped after it. Level by level, since a particle is searched
// only among those of its size.
class Cells {
 public:
  // The first `count` particles.
  Cells(const State& state, const Grid& grid, std::size_t count);

  // What a search reads of a particle, in one place in memory.
  struct Member {
    Vec4 x;  // m, in the domain; w: radius of the ball around the particle
    Id id;
    std::int32_t particle;
  };

  // Calls visit(member, across) for all particles of a level whose balls are nearer than the skin
  // to a ball (w: radius, m) in the domain, in an order that does not matter; across: see
  // Lattice::any.
  template <class Visit>
  void near(std::size_t level, const Vec4& ball, Visit&& visit) const {
    const Table& table = tables_[level];
    if (table.members.empty()) return;
    const double with_skin = ball.w + grid_.skin();
    const double furthest = with_skin + grid_.levels()[level].bound;
    // Cells above one another are neighbours in memory and are examined as one run.
    std::uint32_t begin = 0, end = 0;
    Cell image{};
    constexpr std::uint32_t batch = 32;
    const auto examine = [&] {
      const Vec3 from = ball.vec3() - grid_.wrapped(Vec3::Zero(), image);
      while (begin < end) {
        // Without a branch for each of the many that are not near.
        std::array<std::uint32_t, batch> found;
        std::size_t count = 0;
        for (const std::uint32_t stop = std::min(end, begin + batch); begin < stop; ++begin) {
          const Vec4& x = table.members[begin].x;
          const double dx = x.x - from.x(), dy = x.y - from.y(), dz = x.z - from.z();
          const double reach = with_skin + x.w;
          found[count] = begin;
          count += dx * dx + dy * dy + dz * dz < reach * reach ? 1 : 0;
        }
        for (std::size_t k = 0; k < count; ++k) visit(table.members[found[k]], image);
      }
    };
    grid_.levels()[level].lattice.around(ball.vec3(), furthest,
                                         [&](const Cell& cell, const Cell& across) {
                                           if (!table.holds(cell)) return;
                                           const std::size_t k = table.index(cell);
                                           if (table.begin[k] != end || across != image) {
                                             examine();
                                             begin = table.begin[k], image = across;
                                           }
                                           end = table.begin[k + 1];
                                         });
    examine();
  }
  // Periods that shift the particle into the domain; the same for all levels, whose lattices cover
  // the same box.
  const Cell& wrap(std::size_t particle) const { return wraps_[particle]; }

 private:
  // The cells of one level in compressed rows: members of cell k are in [begin[k], begin[k + 1]).
  struct Table {
    Cell low, high;  // box of the cells in use
    std::vector<std::uint32_t> begin;
    std::vector<Member> members;

    bool holds(const Cell& c) const {
      for (std::size_t a = 0; a < 3; ++a)
        if (c[a] < low[a] || c[a] > high[a]) return false;
      return true;
    }
    std::size_t index(const Cell& c) const {
      const auto n = [&](std::size_t a) { return static_cast<std::size_t>(high[a] - low[a] + 1); };
      const auto i = [&](std::size_t a) { return static_cast<std::size_t>(c[a] - low[a]); };
      return (i(0) * n(1) + i(1)) * n(2) + i(2);
    }
    void fill(const std::vector<Cell>& cells, const std::vector<Member>& unsorted);
  };

  const Grid& grid_;
  std::vector<Cell> wraps_;
  std::vector<Table> tables_;  // of each level
};

}  // namespace trackbed::dem
