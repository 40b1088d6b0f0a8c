// Borders of the cells of an embankment.
//
// Between the feet a column keeps its relative position in the width at each depth; below and
// beside them columns are vertical. Rows end at layer borders, which rise and fall with the natural
// ground.
#include "fem/mesh/embankment.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::fem {

namespace {

// The border of columns nearest to a position; of two the one nearer to the axis, so that both feet
// have theirs at the same distance.
std::int64_t nearest(const std::vector<double>& edges, double place) {
  const auto far = [&](double edge) { return std::abs(edge - place) + 1e-9 * std::abs(edge); };
  const auto found = std::min_element(edges.begin(), edges.end(),
                                      [&](double a, double b) { return far(a) < far(b); });
  return found - edges.begin();
}

}  // namespace

CrossSection GroundParameters::section_at(double at) const {
  const auto resolved = [&](CrossSection one) {
    if (one.height > 0) return one;
    for (std::int64_t l = 0; l < embankment_layers; ++l)
      one.height += layers[static_cast<std::size_t>(l)].thickness;
    return one;
  };
  if (at <= sections.front().x) return resolved(sections.front());
  if (at >= sections.back().x) return resolved(sections.back());
  std::size_t next = 1;
  while (sections[next].x < at) ++next;
  const CrossSection a = resolved(sections[next - 1]), b = resolved(sections[next]);
  const double fraction = (at - a.x) / (b.x - a.x);
  const auto mixed = [&](double from, double to) { return from + fraction * (to - from); };
  // Crest and foot are interpolated linearly; with interpolated slopes the line of the foot would
  // be curved where heights differ.
  const double crest = mixed(a.crest, b.crest), height = mixed(a.height, b.height);
  return {at, crest, height, (mixed(a.foot(), b.foot()) - crest) / height};
}

// Linear between sections: the minimum is at one of them or at an end.
double GroundParameters::narrowest_crest(double from, double to) const {
  double half = std::min(section_at(from).crest, section_at(to).crest);
  for (const CrossSection& section : sections)
    if (section.x > from && section.x < to) half = std::min(half, section.crest);
  return half;
}

std::vector<double> thicknesses(const GroundParameters& p, const CrossSection& section) {
  std::vector<double> found;
  double made = 0;
  for (const Layer& layer : p.layers) found.push_back(layer.thickness);
  const auto raised = static_cast<std::size_t>(p.embankment_layers);
  for (std::size_t l = 0; l < raised; ++l) made += found[l];
  const double more = section.height - made;
  found[raised - 1] += more;
  if (raised < found.size()) found.back() -= more;
  return found;
}

Embankment::Embankment(const GroundParameters& p)
    : parameters_(p), cells_{p.elements_x, p.elements_y, p.elements_over_depth()} {
  for (std::size_t l = p.layers.size(); l-- > 0;)
    layer_of_row_.insert(layer_of_row_.end(), static_cast<std::size_t>(p.layers[l].elements),
                         static_cast<int>(l));
  for (const int layer : layer_of_row_) natural_rows_ += layer >= p.embankment_layers ? 1 : 0;
  for (const double x : p.edges(0)) {
    const CrossSection section = p.section_at(x);
    slices_.push_back({x, section, depths(section)});
  }
  across_ = p.edges(1);
  side_ = {p.y[0], p.y[1]};
  double foot = 0;  // m, mean over the slices
  for (const Slice& slice : slices_) foot += slice.section.foot();
  foot /= static_cast<double>(slices_.size());
  feet_ = {0, cells_[1]};
  const bool beyond = side_[1] > foot + same_place;
  if (side_[0] < -foot - same_place)
    feet_[0] =
        std::clamp<std::int64_t>(nearest(across_, -foot), 1, cells_[1] - 1 - (beyond ? 1 : 0));
  if (beyond)
    feet_[1] = std::clamp<std::int64_t>(nearest(across_, foot), feet_[0] + 1, cells_[1] - 1);
}

std::vector<double> Embankment::depths(const CrossSection& section) const {
  const std::vector<double> thick = thicknesses(parameters_, section);
  std::vector<double> found = {0};
  double above = 0;
  for (std::size_t l = 0; l < thick.size(); ++l) {
    const std::int64_t rows = parameters_.layers[l].elements;
    for (std::int64_t r = 1; r <= rows; ++r)
      found.push_back(above + thick[l] * static_cast<double>(r) / static_cast<double>(rows));
    above += thick[l];
  }
  // The base is exactly level.
  found.back() = 0;
  for (const Layer& layer : parameters_.layers) found.back() += layer.thickness;
  std::reverse(found.begin(), found.end());
  return found;
}

bool Embankment::holds(const Index3& cell) const {
  return cell[2] < natural_rows_ || (cell[1] >= feet_[0] && cell[1] < feet_[1]);
}

bool Embankment::ends_at(double y) const {
  return std::abs(y - side_[0]) < same_place || std::abs(y - side_[1]) < same_place;
}

Vec3 Embankment::corner(const Index3& point) const {
  const Slice& slice = slices_[static_cast<std::size_t>(point[0])];
  const double depth = slice.depth[static_cast<std::size_t>(point[2])];
  const CrossSection& section = slice.section;
  const double half = section.crest + section.slope * std::min(depth, section.height);
  const auto edge = [&](std::int64_t j) { return across_[static_cast<std::size_t>(j)]; };
  const std::int64_t j = point[1];
  const double left = side_[0] == 0 ? 0 : -half;
  double from = left, to = half;
  std::int64_t first = feet_[0], last = feet_[1];
  if (j < feet_[0]) from = side_[0], to = -section.foot(), first = 0, last = feet_[0];
  if (j > feet_[1]) from = section.foot(), to = side_[1], first = feet_[1], last = cells_[1];
  const double fraction = (edge(j) - edge(first)) / (edge(last) - edge(first));
  // Measured from the middle: the same digits on both sides.
  double y = (from + to) / 2 + (fraction - 0.5) * (to - from);
  if (std::abs(y) < 1e-12 * half) y = 0;
  return {slice.x, y, depth == 0 ? 0 : -depth};
}

}  // namespace trackbed::fem
