// Stones as templates: round ones, rings of disks along outlines, clumps of given spheres.
//
// Templates have about unit size and are scaled by the grading. Outlines are the exception: they
// are generated at their size, since pebbles have one radius in all stones.
#include "shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "trackbed/core/error.hpp"

namespace trackbed::bed {

namespace {

constexpr double pi = std::numbers::pi;

// m, between surfaces; over all pairs of a few dozen spheres.
double largest_extent(const std::vector<geom::Sphere>& spheres) {
  double largest = 0;
  for (const auto& a : spheres)
    for (const auto& b : spheres)
      largest = std::max(largest, (a.centre - b.centre).norm() + a.radius + b.radius);
  return largest;
}

std::vector<Eigen::Vector2d> scaled(std::vector<Eigen::Vector2d> polygon, double scale) {
  for (auto& corner : polygon) corner *= scale;
  return polygon;
}

}  // namespace

std::vector<geom::Piece> balls(const std::vector<geom::Sphere>& spheres) {
  std::vector<geom::Piece> pieces;
  for (const auto& s : spheres) pieces.push_back(geom::ball(s.centre, s.radius));
  return pieces;
}

// Disks touch the outline from inside and so cut off its corners; the outline is enlarged until the
// disks, which determine the sieve size, have the required size. Each pass adds the missing width
// to the outline. The slot of the disks has small jumps, as disks appear or vanish along an edge:
// after `passes` the stone is accepted with its actual sieve size.
dem::Template outline_stone(const BedParameters& parameters, double size, std::uint64_t seed) {
  constexpr int passes = 30;
  constexpr double close = 1e-6;
  const auto polygon = geom::outline({parameters.elongation, parameters.angularity, 12}, seed);
  double scale = size / geom::smallest_width(polygon);
  for (int pass = 0;; ++pass) {
    std::vector<geom::Sphere> disks;
    try {
      disks = geom::pebbles_inside(scaled(polygon, scale), parameters.pebble_radius,
                                   parameters.pebble_spacing);
    } catch (const std::invalid_argument&) {
      throw InputError(
          {fmt::format("{}.pebble_radius = {:g} m is too large for a stone with a sieve size of "
                       "{:.4g} mm; give a smaller radius",
                       parameters.section, parameters.pebble_radius, 1e3 * size)});
    }
    const double slot = geom::smallest_slot(disks);
    if (std::abs(slot / size - 1) < close || pass == passes)
      return geom::template_of(balls(disks), geom::polygon_solid(scaled(polygon, scale)), slot);
    scale += (size - slot) / geom::smallest_width(polygon);
  }
}

// Disk: area pi d^2/4, polar inertia over mass d^2/8. Ball: pi d^3/6 and d^2/10. d = 1 m.
dem::Template round_stone(Dimension dimension) {
  const bool plane = dimension == Dimension::plane;
  dem::Template shape;
  shape.pieces = {geom::ball(Vec3::Zero(), 0.5)};
  shape.volume = plane ? pi / 4 : pi / 6;
  shape.gyration = plane ? Vec3(0.0625, 0.125, 0.0625) : Vec3::Constant(0.1);
  return shape;
}

// In any length unit: the stone is scaled to an extent of 1 m. In a plane y is ignored.
dem::Template clump_stone(const BedParameters& parameters, Dimension dimension) {
  const bool plane = dimension == Dimension::plane;
  std::vector<geom::Sphere> spheres;
  for (std::size_t k = 0; k + 3 < parameters.clump.size(); k += 4) {
    const double* given = &parameters.clump[k];
    spheres.push_back({Vec3(given[0], plane ? 0 : given[1], given[2]), given[3]});
  }
  if (spheres.empty()) throw InputError({"bed.clump contains no sphere"});
  const double extent = largest_extent(spheres);
  for (auto& s : spheres) s.centre /= extent, s.radius /= extent;
  constexpr int cells = 192;
  return plane ? geom::template_of(balls(spheres), geom::union_lamina(spheres),
                                   geom::smallest_slot(spheres))
               : geom::template_of(balls(spheres), geom::union_solid(spheres, cells),
                                   geom::smallest_hole(spheres));
}

}  // namespace trackbed::bed
