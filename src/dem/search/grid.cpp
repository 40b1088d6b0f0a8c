// Cells, their images across periodic sides, and the partition of cells over ranks. Everything here
// is a pure function of numbers that are the same on every rank: nothing is sent, and all ranks
// compute the same map.
#include "dem/search/grid.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trackbed/core/error.hpp"
#include "trackbed/par/partition.hpp"

namespace trackbed::dem {

namespace {

constexpr const char* axis_name[] = {"x", "y", "z"};
constexpr double most_cells = 1 << 22;  // bounds the map for stones tiny beside the domain
// A rebuild examines all cells: for a few stones in a wide domain this would be all of the work.
constexpr double cells_per_particle = 64, fewest_cells = 4096;

}  // namespace

// A whole number of cells along each axis, none shorter than `edge`: whatever is within `edge` of a
// point is in its cell or the ones around it. Larger cells are slower, never wrong.
Lattice::Lattice(const Domain& domain, double edge, double most)
    : domain_(domain), extent_(domain.high - domain.low) {
  const auto cells_of = [&](double length) {
    return (extent_ / length).array().floor().max(1).prod();
  };
  double length = edge;
  // Counted in doubles: before it is bounded the product may not fit in an int.
  while (cells_of(length) > most) length *= 1.1;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    count_[axis] = std::max(static_cast<int>(extent_[a] / length), 1);
    edge_[a] = extent_[a] / count_[axis];
  }
}

std::size_t Lattice::size() const {
  return index({count_[0] - 1, count_[1] - 1, count_[2] - 1}) + 1;
}

Cell Lattice::cell(std::size_t index) const {
  const auto nz = static_cast<std::size_t>(count_[2]), ny = static_cast<std::size_t>(count_[1]);
  return {static_cast<int>(index / (nz * ny)), static_cast<int>(index / nz % ny),
          static_cast<int>(index % nz)};
}

Vec3 Lattice::centre(std::size_t index) const {
  const Cell c = cell(index);
  return domain_.low + Vec3(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5).cwiseProduct(edge_);
}

// The cell of a point. Across periodic sides floor(x / L) whole periods are subtracted; beyond
// other sides the last cell is taken. A position that is not a number is assigned to the first
// cell; the rebuild reports it.
Lattice::Image Lattice::locate(const Vec3& position) const {
  Image image{};
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double along = (position[a] - domain_.low[a]) / extent_[a];  // 0..1 inside
    const double turns = domain_.periodic[axis] && std::isfinite(along) ? std::floor(along) : 0.0;
    image.wrap[axis] = -static_cast<int>(turns);
    // along - turns may round up to 1: limited to below the end of the last cell.
    const double inside = (along - turns) * count_[axis];
    image.cell[axis] = inside > 0 ? static_cast<int>(std::min(inside, count_[axis] - 0.5)) : 0;
  }
  return image;
}

// Cells covered by a box, first and last along each axis; not clipped at periodic sides, where
// numbers below 0 and beyond the last are those of images (`any`). Boxes longer than three periods
// contain every possible image.
Cell Lattice::lowest(const Vec3& low, const Vec3& high) const {
  Cell first;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double n = count_[axis], cells = (low[a] - domain_.low[a]) / extent_[a] * n;
    if (domain_.periodic[axis])
      first[axis] =
          high[a] - low[a] < 3 * extent_[a] ? static_cast<int>(std::floor(cells)) : -count_[axis];
    else
      first[axis] = cells > 0 ? static_cast<int>(std::min(cells, n - 0.5)) : 0;
  }
  return first;
}

Cell Lattice::highest(const Vec3& low, const Vec3& high) const {
  Cell last;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double n = count_[axis], cells = (high[a] - domain_.low[a]) / extent_[a] * n;
    if (domain_.periodic[axis])
      last[axis] = high[a] - low[a] < 3 * extent_[a] ? static_cast<int>(std::floor(cells))
                                                     : 2 * count_[axis] - 1;
    else
      last[axis] = cells > 0 ? static_cast<int>(std::min(cells, n - 0.5)) : 0;
  }
  return last;
}

// Cells as long as the largest particle of their level and the skin: two of one level that may
// touch are in neighbouring cells.
Grid::Grid(const Domain& domain, std::span<const double> bounds, double skin,
           std::int64_t particles)
    : domain_(domain), skin_(skin) {
  levels_.clear();
  const double most =
      std::min(most_cells, fewest_cells + cells_per_particle * static_cast<double>(particles));
  // All levels cover the same box, each with its own cells.
  for (const double bound : bounds)
    levels_.push_back({bound, Lattice(domain, 2 * bound + skin, most)});
  owner_.assign(levels_[0].lattice.size(), 0);
  // With fewer than three a particle could touch a partner and the partner's image, and one entry
  // per pair would not be sufficient.
  const double least = 3 * (2 * bounds.back() + skin);
  std::vector<std::string> problems;
  for (int a = 0; a < 3; ++a)
    if (domain.periodic[static_cast<std::size_t>(a)] && period(a) < least)
      problems.push_back(
          fmt::format("the periodic length of the domain is {:.4g} m along {}; it must be at least "
                      "{:.4g} m, 3 times the diameter of the largest particle including the skin; "
                      "make the domain longer or dem.skin smaller",
                      period(a), axis_name[a], least));
  if (!problems.empty()) throw InputError(problems);
}

// The first level for this bounding radius, m; beyond the last: the last.
std::size_t Grid::level_of(double bound) const {
  std::size_t level = 0;
  while (level + 1 < levels_.size() && bound > levels_[level].bound) ++level;
  return level;
}

// There is no outside beyond periodic sides. A position that is not a number is lost as well.
bool Grid::outside(const Vec3& position) const {
  if (!position.allFinite()) return true;
  for (int a = 0; a < 3; ++a)
    if (!domain_.periodic[static_cast<std::size_t>(a)] &&
        (position[a] < domain_.low[a] || position[a] > domain_.high[a]))
      return true;
  return false;
}

bool Grid::owns_part_of(const Vec3& low, const Vec3& high, int rank) const {
  return levels_[0].lattice.any(low, high,
                                [&](const Cell& cell, const Cell&) { return owner(cell) == rank; });
}

namespace {

// The up to six cells beside a cell, across periodic sides too.
template <class Visit>
void for_sides(const Lattice& lattice, std::size_t cell, Visit&& visit) {
  const Vec3 centre = lattice.centre(cell);
  for (int a = 0; a < 3; ++a)
    for (const int side : {-1, 1}) {
      Vec3 at = centre;
      at[a] += side * lattice.edge()[a];
      const std::size_t other = lattice.index(lattice.locate(at).cell);
      if (other != cell) visit(other);  // beyond the domain lies the cell itself
    }
}

// The work along a cut between two cells is done twice: the contacts between them, of which a cell
// with six neighbours has a sixth with each, and the cost of the ghosts. Only occupied cells are
// vertices: empty ones cost nothing and would connect unrelated heaps.
par::Graph graph_of(const Lattice& lattice, const std::vector<std::size_t>& occupied,
                    const std::vector<double>& work) {
  std::vector<std::int32_t> number(lattice.size(), -1);
  for (std::size_t v = 0; v < occupied.size(); ++v)
    number[occupied[v]] = static_cast<std::int32_t>(v);
  par::Graph graph;
  for (const std::size_t cell : occupied) {
    graph.weights.push_back(work[cell]);
    for_sides(lattice, cell, [&](std::size_t other) {
      if (number[other] < 0) return;
      graph.neighbours.push_back(number[other]);
      graph.edge_weights.push_back((work[cell] + work[other]) / 6);
    });
    graph.begin.push_back(static_cast<std::int64_t>(graph.neighbours.size()));
  }
  return graph;
}

}  // namespace

// Both partitions are tried. METIS finds short cuts through heaps of any form; bisection gives
// slabs along the longest side, which are optimal in a long thin bed, and always succeeds. Cost:
// METIS on the occupied cells, on each rank separately; only for new partitions.
double Grid::partition(const std::vector<double>& work, int ranks) {
  const Lattice& lattice = levels_[0].lattice;
  std::vector<std::size_t> occupied;
  std::vector<Vec3> centres;
  for (std::size_t c = 0; c < cells(); ++c)
    if (work[c] > 0) occupied.push_back(c), centres.push_back(lattice.centre(c));
  const par::Graph graph = graph_of(lattice, occupied, work);
  // Bisection considers the weights only, METIS the cut edges too; the one with the least work of
  // the busiest rank is taken.
  std::vector<int> best = par::bisect(centres, graph.weights, ranks);
  double worst = par::worst_part(graph, best, ranks);
  const std::vector<int> other = ranks > 1 ? par::partition_graph(graph, ranks) : best;
  if (!other.empty() && par::worst_part(graph, other, ranks) < worst)
    best = other, worst = par::worst_part(graph, other, ranks);
  owner_.assign(cells(), -1);
  for (std::size_t v = 0; v < occupied.size(); ++v) owner_[occupied[v]] = best[v];
  fill_empty_cells(occupied);
  return worst;
}

double Grid::worst(const std::vector<double>& work, int ranks) const {
  std::vector<std::size_t> occupied;
  std::vector<int> owners;
  for (std::size_t c = 0; c < cells(); ++c)
    if (work[c] > 0) occupied.push_back(c), owners.push_back(owner_[c]);
  return par::worst_part(graph_of(levels_[0].lattice, occupied, work), owners, ranks);
}

// Empty cells are assigned with the nearest occupied one, so that particles that move there stay
// with their neighbours. Breadth first from all occupied cells at once, in the order of cells: the
// same on every rank.
void Grid::fill_empty_cells(const std::vector<std::size_t>& occupied) {
  std::vector<std::size_t> queue = occupied;
  for (std::size_t k = 0; k < queue.size(); ++k)
    for_sides(levels_[0].lattice, queue[k], [&](std::size_t other) {
      if (owner_[other] >= 0) return;
      owner_[other] = owner_[queue[k]];
      queue.push_back(other);
    });
  // No particles yet: rank 0 has all cells, so that every cell has an owner.
  if (occupied.empty()) std::fill(owner_.begin(), owner_.end(), 0);
}

}  // namespace trackbed::dem
