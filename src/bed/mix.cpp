// The templates and their frequencies. Round stones and given clumps are one template at any scale,
// polyhedra are several; each outline has its own size, because its pebbles must not be scaled.
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

// Bounds at unit scale are computed once, so that draws need no geometry.
Mix::Mix(const BedParameters& parameters, Dimension dimension, std::vector<dem::Template> library)
    : grading_(in_metres(parameters.sieve), parameters.passing,
               dimension == Dimension::plane ? 2 : 3),
      power_(dimension == Dimension::plane ? 2 : 3),
      templates_(std::move(library)) {
  if (parameters.stone == StoneKind::pebbles) {
    if (dimension != Dimension::plane)
      throw InputError(
          {"bed.stone = \"pebbles\" is for plane models only; use dimension = \"plane\" or other "
           "stones"});
    add_outlines(parameters);
  } else {
    add_scaled(parameters, dimension);
  }
  for (const dem::Template& shape : templates_) {
    bounds_.push_back(geom::bounding_radius(shape));
    extents_.push_back(geom::greatest_extent(shape.pieces));
  }
}

// Each outline has its own size, so that all pebbles have the same radius. It represents an equal
// fraction of the mass, at the middle of its fraction of the grading. Number fractions follow from
// equal masses: proportional to 1/volume.
void Mix::add_outlines(const BedParameters& parameters) {
  const auto seed = static_cast<std::uint64_t>(parameters.seed);
  double stones = 0;
  for (std::int64_t k = 0; k < parameters.shapes; ++k) {
    const double fraction = (static_cast<double>(k) + 0.5) / static_cast<double>(parameters.shapes);
    templates_.push_back(outline_stone(parameters, grading_.by_mass(fraction),
                                       mix(seed ^ mix(static_cast<std::uint64_t>(k)))));
    stones += 1 / templates_.back().volume;
    frequency_.push_back(stones);
  }
  for (double& fraction : frequency_) fraction /= stones;
}

// Kind and dimension must be compatible; the message lists the compatible kinds.
void Mix::add_scaled(const BedParameters& parameters, Dimension dimension) {
  const bool given = parameters.stone == StoneKind::clump && !parameters.clump.empty();
  if (parameters.stone == StoneKind::disk)
    templates_.push_back(round_stone(dimension));
  else if (given)
    templates_.push_back(clump_stone(parameters, dimension));
  else if (dimension == Dimension::plane)
    throw InputError(
        {"bed.stone: these stones are for three-dimensional models only; a plane model takes disk, "
         "pebbles, or clump with spheres in bed.clump"});
  else if (parameters.stone != StoneKind::library)
    for (std::int64_t k = 0; k < parameters.shapes; ++k)
      templates_.push_back(polyhedron_stone(parameters, k));
}

// Consecutive sizes have different shapes, so that each shape occurs in all sizes. u = (k +
// 1/2)/count is the middle of the k-th interval, so that no draw lies at the very ends of the
// grading.
Draw Mix::draw(std::uint64_t k, std::uint64_t count) const {
  const double u = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
  if (frequency_.empty()) {
    const std::size_t shape = k % templates_.size();
    return {static_cast<int>(shape), grading_.by_number(u) / templates_[shape].sieve};
  }
  const auto found = std::upper_bound(frequency_.begin(), frequency_.end() - 1, u);
  return {static_cast<int>(found - frequency_.begin()), 1};
}

double Mix::bound(const Draw& draw) const {
  return bounds_[static_cast<std::size_t>(draw.shape)] * draw.scale;
}

double Mix::extent(const Draw& draw) const {
  return extents_[static_cast<std::size_t>(draw.shape)] * draw.scale;
}

// From the largest stone of each shape, not from the largest sieve: the bound of an elongated shape
// is larger than its sieve size.
double Mix::largest_bound() const {
  double largest = 0;
  for (std::size_t k = 0; k < templates_.size(); ++k) {
    const double scale = frequency_.empty() ? grading_.by_number(1) / templates_[k].sieve : 1;
    largest = std::max(largest, bounds_[k] * scale);
  }
  return largest;
}

// Scaled shapes: mean volume of the shapes at sieve size 1, times the number mean of s^D. Outlines
// have equal masses, so the mean is harmonic.
double Mix::mean_volume() const {
  const auto shapes = static_cast<double>(templates_.size());
  double volume = 0, stones = 0;
  for (const dem::Template& shape : templates_) {
    volume += shape.volume / std::pow(shape.sieve, power_) / shapes;
    stones += 1 / shape.volume / shapes;
  }
  return frequency_.empty() ? volume * grading_.mean_power() : 1 / stones;
}

}  // namespace trackbed::bed
