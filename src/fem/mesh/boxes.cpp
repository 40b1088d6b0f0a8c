#include "fem/mesh/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace trackbed::fem {

namespace {

constexpr double unit = 1000;  // costs are summed as integers, which no order of ranks changes

std::size_t longest_side(const IndexBox& box) {
  std::size_t axis = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (box.end[a] - box.begin[a] > box.end[axis] - box.begin[axis]) axis = a;
  return axis;
}

Index3 element_at(const IndexBox& box, std::int64_t k) {
  const std::int64_t nx = box.end[0] - box.begin[0], ny = box.end[1] - box.begin[1];
  return {box.begin[0] + k % nx, box.begin[1] + k / nx % ny, box.begin[2] + k / (nx * ny)};
}

// The layer at which the lower side has the fraction `wanted` of the cost: a layer belongs to the
// side that contains most of it. Neither side is left empty if there are two
// layers or more.
std::int64_t cut_at(std::span<const std::int64_t> layers, double wanted) {
  const double all =
      static_cast<double>(std::accumulate(layers.begin(), layers.end(), std::int64_t{0}));
  double below = 0;
  std::int64_t cut = 0;
  for (const std::int64_t layer : layers) {
    if (below + 0.5 * static_cast<double>(layer) >= wanted * all) break;
    below += static_cast<double>(layer), ++cut;
  }
  const auto count = std::ssize(layers);
  return count < 2 ? count : std::clamp<std::int64_t>(cut, 1, count - 1);
}

}  // namespace

Boxes::Boxes(const par::Comm& comm, const Index3& elements,
             const std::function<double(const Index3&)>& cost)
    : boxes_(static_cast<std::size_t>(comm.size())) {
  parts_.push_back({{{0, 0, 0}, elements}, 0, comm.size()});
  // Parts of one halving after the other: all boxes of a halving are cut at the same time.
  for (std::size_t from = 0; from < parts_.size();) {
    const std::size_t end = parts_.size();
    cut_all(from, comm, cost);
    from = end;
  }
  for (const Part& part : parts_)
    if (part.ranks == 1) boxes_[static_cast<std::size_t>(part.first)] = part.box;
}

// The ranks of a box sum the cost of its layers together, each over an equal part of its elements.
void Boxes::cut_all(std::size_t from, const par::Comm& comm,
                    const std::function<double(const Index3&)>& cost) {
  const std::size_t end = parts_.size();
  std::vector<std::int64_t> layers;
  std::vector<std::size_t> begin;
  for (std::size_t n = from; n < end; ++n) {
    Part& part = parts_[n];
    part.axis = longest_side(part.box);
    begin.push_back(layers.size());
    if (part.ranks == 1) continue;
    layers.resize(layers.size() +
                  static_cast<std::size_t>(part.box.end[part.axis] - part.box.begin[part.axis]));
    const int mine = comm.rank() - part.first;
    if (mine < 0 || mine >= part.ranks) continue;
    const std::int64_t count = part.box.size();
    for (std::int64_t k = count * mine / part.ranks; k < count * (mine + 1) / part.ranks; ++k) {
      const Index3 at = element_at(part.box, k);
      layers[begin.back() + static_cast<std::size_t>(at[part.axis] - part.box.begin[part.axis])] +=
          std::max<std::int64_t>(1, std::llround(unit * cost(at)));
    }
  }
  begin.push_back(layers.size());
  comm.sum(std::span(layers));
  for (std::size_t n = from; n < end; ++n) {
    const Part whole = parts_[n];
    if (whole.ranks == 1) continue;
    const auto own =
        std::span(layers).subspan(begin[n - from], begin[n - from + 1] - begin[n - from]);
    const int below = whole.ranks / 2;
    Part lower{whole.box, whole.first, below},
        upper{whole.box, whole.first + below, whole.ranks - below};
    const std::int64_t cut =
        whole.box.begin[whole.axis] + cut_at(own, static_cast<double>(below) / whole.ranks);
    lower.box.end[whole.axis] = upper.box.begin[whole.axis] = cut;
    parts_[n].cut = cut, parts_[n].lower = parts_.size();
    parts_.push_back(lower), parts_.push_back(upper);
  }
}

int Boxes::rank_of(const Index3& element) const {
  const Part* part = &parts_[0];
  while (part->ranks > 1) part = &parts_[part->lower + (element[part->axis] < part->cut ? 0 : 1)];
  return part->first;
}

}  // namespace trackbed::fem
