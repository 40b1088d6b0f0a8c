// Borders of elements along each axis.
#include <algorithm>
#include <cmath>

#include "fem/mesh/lattice.hpp"

namespace trackbed::fem {

namespace {

std::vector<double> even(double from, double to, std::int64_t elements) {
  const double size = (to - from) / static_cast<double>(elements);
  std::vector<double> edges;
  for (std::int64_t i = 0; i <= elements; ++i)
    edges.push_back(from + static_cast<double>(i) * size);
  return edges;
}

// Sum of the lengths 1, r, r^2 ... of a number of elements.
double sum_of(double ratio, std::int64_t elements) {
  return (std::pow(ratio, static_cast<double>(elements)) - 1) / (ratio - 1);
}

// Elements grow away from `fine` on both sides. The numbers of elements of the sides are chosen
// such that the two adjacent elements at `fine` differ least. A side shorter than half of its
// neighbour would be a sliver, which shortens all explicit steps: it gets no border, and elements
// are finest at that end.
std::vector<double> away_from(double fine, double ratio, double from, double to,
                              std::int64_t elements) {
  const double left = fine - from, right = to - fine;
  if (left <= 0 || right <= 0) {
    std::vector<double> edges = {0};
    const double first = (to - from) / sum_of(ratio, elements);
    for (std::int64_t i = 1; i <= elements; ++i) edges.push_back(first * sum_of(ratio, i));
    for (double& edge : edges) edge = left <= 0 ? from + edge : to - edge;
    edges.front() = left <= 0 ? from : to;
    edges.back() = left <= 0 ? to : from;
    if (left > 0) std::reverse(edges.begin(), edges.end());
    return edges;
  }
  const auto uneven = [&](std::int64_t before) {
    return std::abs(
        std::log(left / sum_of(ratio, before) * sum_of(ratio, elements - before) / right));
  };
  std::int64_t before = 1;
  for (std::int64_t k = 2; k < elements; ++k)
    if (uneven(k) < uneven(before)) before = k;
  const std::int64_t behind = elements - before;
  if (before == 1 && 2 * left < right / sum_of(ratio, behind))
    return away_from(from, ratio, from, to, elements);
  if (behind == 1 && 2 * right < left / sum_of(ratio, before))
    return away_from(to, ratio, from, to, elements);
  std::vector<double> edges = away_from(fine, ratio, from, fine, before);
  const std::vector<double> rest = away_from(fine, ratio, fine, to, behind);
  edges.insert(edges.end(), rest.begin() + 1, rest.end());
  return edges;
}

// From the bottom up. Layers with element numbers of their own end at element borders.
std::vector<double> over_depth(const GroundParameters& p) {
  double depth = 0;
  for (const Layer& layer : p.layers) depth += layer.thickness;
  if (!p.layers_have_elements()) return even(-depth, 0, p.elements_z);
  std::vector<double> edges = {-depth};
  for (std::size_t l = p.layers.size(); l-- > 0;) {
    depth = 0;
    for (std::size_t above = 0; above < l; ++above) depth += p.layers[above].thickness;
    const std::vector<double> layer =
        even(-depth - p.layers[l].thickness, -depth, p.layers[l].elements);
    edges.insert(edges.end(), layer.begin() + 1, layer.end());
    edges.back() = -depth;
  }
  return edges;
}

}  // namespace

bool GroundParameters::layers_have_elements() const {
  return std::any_of(layers.begin(), layers.end(),
                     [](const Layer& layer) { return layer.elements > 0; });
}

std::int64_t GroundParameters::elements_over_depth() const {
  if (!layers_have_elements()) return elements_z;
  std::int64_t sum = 0;
  for (const Layer& layer : layers) sum += layer.elements;
  return sum;
}

std::vector<double> GroundParameters::edges(int axis) const {
  if (axis == 2) return over_depth(*this);
  const std::vector<double>& range = axis == 0 ? x : y;
  const std::int64_t elements = axis == 0 ? elements_x : elements_y;
  const double ratio = axis == 0 ? ratio_x : ratio_y;
  if (ratio == 1 || elements == 1) return even(range[0], range[1], elements);
  const double fine = std::clamp(axis == 0 ? fine_x : fine_y, range[0], range[1]);
  return away_from(fine, ratio, range[0], range[1], elements);
}

}  // namespace trackbed::fem
