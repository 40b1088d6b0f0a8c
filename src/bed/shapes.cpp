// Stones as templates: round ones, outlines filled with disks, clumps of given spheres.
// Openings are found by looking from a raster of directions: exact minimal boxes of sphere unions
// would be much more code for a number that grades ballast to a per cent.
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

double width_along(const std::vector<geom::Sphere>& spheres, const Vec3& direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& s : spheres) {
    const double along = direction.dot(s.centre);
    low = std::min(low, along - s.radius);
    high = std::max(high, along + s.radius);
  }
  return high - low;
}

// Side of the square around the shadow of the spheres along `view`, the smallest over its turns.
double square_around(const std::vector<geom::Sphere>& spheres, const Vec3& view) {
  constexpr int turns = 30;  // 3 degrees apart: side right to 0.04 %
  const Vec3 u = view.unitOrthogonal(), v = view.cross(u);
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < turns; ++k) {
    const double angle = pi / 2 * k / turns, c = std::cos(angle), s = std::sin(angle);
    smallest = std::min(smallest, std::max(width_along(spheres, c * u + s * v),
                                           width_along(spheres, c * v - s * u)));
  }
  return smallest;
}

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

double smallest_slot(const std::vector<geom::Sphere>& disks) {
  constexpr int turns = 720;  // a quarter of a degree apart: 0.2 % of the extent at most
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < turns; ++k) {
    const double angle = pi * k / turns;
    smallest = std::min(smallest, width_along(disks, {std::cos(angle), 0, std::sin(angle)}));
  }
  return smallest;
}

double smallest_hole(const std::vector<geom::Sphere>& spheres) {
  constexpr int views = 1000;  // Fibonacci lattice on half a sphere, about 4.5 degrees apart
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < views; ++k) {
    const double z = (k + 0.5) / views, r = std::sqrt(1 - z * z);
    const double turn = 2 * pi * k / std::numbers::phi;
    smallest =
        std::min(smallest, square_around(spheres, {r * std::cos(turn), r * std::sin(turn), z}));
  }
  return smallest;
}

dem::Template template_of(const std::vector<geom::Sphere>& spheres, const geom::Solid& solid,
                          double sieve) {
  dem::Template shape;
  const Quat back = solid.axes.conjugate();
  for (const auto& s : spheres)
    shape.pieces.push_back(geom::ball(back * (s.centre - solid.centre), s.radius));
  shape.volume = solid.volume;
  shape.gyration = solid.gyration;
  shape.sieve = sieve;
  return shape;
}

// Disks touch the outline from within and so cut its corners; the outline is enlarged until the
// disks, which are what passes a sieve, have the wanted size.
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
      throw InputError({fmt::format(
          "bed.pebble_radius = {:g} m is too large for a stone of sieve size {:.4g} mm",
          parameters.pebble_radius, 1e3 * size)});
    }
    const double slot = smallest_slot(disks);
    if (std::abs(slot / size - 1) < close || pass == passes)
      return template_of(disks, geom::polygon_solid(scaled(polygon, scale)), slot);
    scale += (size - slot) / geom::smallest_width(polygon);
  }
}

dem::Template round_stone(Dimension dimension) {
  const bool plane = dimension == Dimension::plane;
  dem::Template shape;
  shape.pieces = {geom::ball(Vec3::Zero(), 0.5)};
  shape.volume = plane ? pi / 4 : pi / 6;
  shape.gyration = plane ? Vec3(0.0625, 0.125, 0.0625) : Vec3::Constant(0.1);
  return shape;
}

dem::Template clump_stone(const BedParameters& parameters, Dimension dimension) {
  const bool plane = dimension == Dimension::plane;
  std::vector<geom::Sphere> spheres;
  for (std::size_t k = 0; k + 3 < parameters.clump.size(); k += 4) {
    const double* given = &parameters.clump[k];
    spheres.push_back({Vec3(given[0], plane ? 0 : given[1], given[2]), given[3]});
  }
  if (spheres.empty()) throw InputError({"bed.clump holds no sphere"});
  const double extent = largest_extent(spheres);
  for (auto& s : spheres) s.centre /= extent, s.radius /= extent;
  return plane ? template_of(spheres, geom::union_lamina(spheres), smallest_slot(spheres))
               : template_of(spheres, geom::union_solid(spheres, 192), smallest_hole(spheres));
}

}  // namespace trackbed::bed
