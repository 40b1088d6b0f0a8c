#include "grid.hpp"

#include <fmt/format.h>

#include <cmath>

#include "trackbed/core/error.hpp"
#include "trackbed/par/partition.hpp"

namespace trackbed::dem {

namespace {

constexpr const char* axis_name[] = {"x", "y", "z"};
constexpr double most_cells = 1 << 22;  // bounds the map when stones are tiny beside the domain

}  // namespace

Grid::Grid(const Domain& domain, double edge) : domain_(domain), extent_(domain.high - domain.low) {
  std::vector<std::string> problems;
  const auto cells_of = [&](double length) {
    return (extent_ / length).array().floor().max(1).prod();
  };
  double length = edge;
  while (cells_of(length) > most_cells) length *= 1.1;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    count_[axis] = std::max(static_cast<int>(extent_[a] / length), 1);
    edge_[a] = extent_[a] / count_[axis];
    if (domain.periodic[axis] && count_[axis] < 3)
      problems.push_back(fmt::format(
          "the domain is {:.4g} m long in {} where it is periodic: it must be at least 3 times the "
          "largest particle with skin, {:.4g} m",
          extent_[a], axis_name[a], 3 * edge));
  }
  if (!problems.empty()) throw InputError(problems);
  owner_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                    static_cast<std::size_t>(count_[2]),
                0);
}

Grid::Image Grid::locate(const Vec3& position) const {
  Image image{};
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double along = (position[a] - domain_.low[a]) / extent_[a];  // 0..1 inside
    const double turns = domain_.periodic[axis] ? std::floor(along) : 0.0;
    image.wrap[axis] = -static_cast<int>(turns);
    const double inside = (along - turns) * count_[axis];
    image.cell[axis] = static_cast<int>(std::clamp(inside, 0.0, count_[axis] - 0.5));
  }
  return image;
}

bool Grid::outside(const Vec3& position) const {
  if (!position.allFinite()) return true;
  for (int a = 0; a < 3; ++a)
    if (!domain_.periodic[static_cast<std::size_t>(a)] &&
        (position[a] < domain_.low[a] || position[a] > domain_.high[a]))
      return true;
  return false;
}

bool Grid::reachable(std::array<int, 3>& cell, std::array<int, 3>& image) const {
  for (std::size_t a = 0; a < 3; ++a) {
    if (cell[a] >= 0 && cell[a] < count_[a]) continue;
    if (!domain_.periodic[a]) return false;
    image[a] = cell[a] < 0 ? -1 : 1;
    cell[a] -= image[a] * count_[a];
  }
  return true;
}

void Grid::share_out(const std::vector<double>& weights, int ranks) {
  std::vector<Vec3> centres(cells());
  std::vector<double> costs(cells());
  for (std::size_t c = 0; c < cells(); ++c) {
    centres[c] = low_of(c) + 0.5 * edge_;
    costs[c] = weights[c] + 1e-3;  // empty cells are shared out too
  }
  owner_ = par::bisect(centres, costs, ranks);
}

Vec3 Grid::low_of(std::size_t cell) const {
  const auto nz = static_cast<std::size_t>(count_[2]), ny = static_cast<std::size_t>(count_[1]);
  const Vec3 steps(static_cast<double>(cell / (nz * ny)), static_cast<double>(cell / nz % ny),
                   static_cast<double>(cell % nz));
  return domain_.low + steps.cwiseProduct(edge_);
}

}  // namespace trackbed::dem
