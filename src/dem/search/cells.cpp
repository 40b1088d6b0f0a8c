// Counting sort into cells: two passes over the particles and one over the cells of the box that
// they fill. Alternatives: a hash of cells needs no box but a look-up per cell and gives an
// arbitrary order; linked lists through the cells need no sort but jump through memory when they
// are read.
#include "dem/search/cells.hpp"

namespace trackbed::dem {

Cells::Cells(const State& state, const Grid& grid, std::size_t count)
    : grid_(grid), tables_(grid.levels().size()) {
  std::vector<std::vector<Cell>> cells(tables_.size());
  std::vector<std::vector<Member>> members(tables_.size());
  wraps_.reserve(count);
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t level = grid.level_of(state.x[b].w);
    // A position that is not a number is assigned to the first cell; the rebuild has reported it
    // before.
    const Lattice::Image image = grid.levels()[level].lattice.locate(state.x[b].vec3());
    wraps_.push_back(image.wrap);
    cells[level].push_back(image.cell);
    const Vec3 home = grid.wrapped(state.x[b].vec3(), image.wrap);
    members[level].push_back(
        {{home.x(), home.y(), home.z(), state.x[b].w}, state.id[b], static_cast<std::int32_t>(b)});
  }
  for (std::size_t level = 0; level < tables_.size(); ++level)
    tables_[level].fill(cells[level], members[level]);
}

void Cells::Table::fill(const std::vector<Cell>& cells, const std::vector<Member>& unsorted) {
  if (cells.empty()) return;
  low = high = cells.front();
  for (const Cell& c : cells)
    for (std::size_t a = 0; a < 3; ++a)
      low[a] = std::min(low[a], c[a]), high[a] = std::max(high[a], c[a]);
  // Counts are stored one place after their cell, so that the partial sum is the begin of each
  // cell.
  begin.assign(index(high) + 2, 0);
  for (const Cell& c : cells) ++begin[index(c) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  members.resize(cells.size());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  // In the order of input: within a cell particles ascend.
  for (std::size_t k = 0; k < cells.size(); ++k) members[next[index(cells[k])]++] = unsorted[k];
}

}  // namespace trackbed::dem
