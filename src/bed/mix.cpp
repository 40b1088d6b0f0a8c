// Which stones there are and how often. Round stones and clumps are one template at any scale;
// outlines are as many templates as shapes, because their pebbles must not scale with them.
#include "mix.hpp"

#include <algorithm>
#include <cmath>

#include "shapes.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::bed {

namespace {

std::vector<double> in_metres(std::vector<double> sieve) {
  for (double& opening : sieve) opening *= 1e-3;
  return sieve;
}

}  // namespace

Mix::Mix(const BedParameters& parameters, Dimension dimension)
    : grading_(in_metres(parameters.sieve), parameters.passing,
               dimension == Dimension::plane ? 2 : 3),
      power_(dimension == Dimension::plane ? 2 : 3) {
  if (parameters.stone == StoneKind::pebbles) {
    if (dimension != Dimension::plane)
      throw InputError(
          {"bed.stone = \"pebbles\" makes plane stones: the model must be a plane one"});
    add_outlines(parameters);
  } else {
    add_scaled(parameters, dimension);
  }
  for (const dem::Template& shape : templates_) bounds_.push_back(geom::bounding_radius(shape));
}

// Each outline has a size of its own, so that all pebbles have the same radius. It stands for an
// equal share of the mass, in the middle of its share of the grading.
void Mix::add_outlines(const BedParameters& parameters) {
  const auto seed = static_cast<std::uint64_t>(parameters.seed);
  double stones = 0;
  for (std::int64_t k = 0; k < parameters.shapes; ++k) {
    const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(parameters.shapes);
    templates_.push_back(outline_stone(parameters, grading_.by_mass(share),
                                       mix(seed ^ mix(static_cast<std::uint64_t>(k)))));
    stones += 1 / templates_.back().volume;
    frequency_.push_back(stones);
  }
  for (double& share : frequency_) share /= stones;
}

void Mix::add_scaled(const BedParameters& parameters, Dimension dimension) {
  templates_.push_back(parameters.stone == StoneKind::disk ? round_stone(dimension)
                                                           : clump_stone(parameters, dimension));
}

Draw Mix::draw(double u) const {
  if (frequency_.empty()) return {0, grading_.by_number(u) / templates_[0].sieve};
  const auto found = std::upper_bound(frequency_.begin(), frequency_.end() - 1, u);
  return {static_cast<int>(found - frequency_.begin()), 1};
}

double Mix::bound(const Draw& draw) const {
  return bounds_[static_cast<std::size_t>(draw.shape)] * draw.scale;
}

double Mix::largest_bound() const {
  if (frequency_.empty()) return bounds_[0] * grading_.by_number(1) / templates_[0].sieve;
  return *std::max_element(bounds_.begin(), bounds_.end());
}

double Mix::mean_volume() const {
  if (frequency_.empty())
    return templates_[0].volume * grading_.mean_power() / std::pow(templates_[0].sieve, power_);
  double stones = 0;
  for (const dem::Template& shape : templates_) stones += 1 / shape.volume;
  return static_cast<double>(templates_.size()) / stones;
}

}  // namespace trackbed::bed
