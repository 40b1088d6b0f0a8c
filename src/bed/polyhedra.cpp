// Irregular stones in space: rounded polyhedra, whole, in convex pieces, or filled with spheres.
//
// All three kinds are generated from the same polyhedra, so that the effect of the contact model on
// a bed can be distinguished from the effect of the shape.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "shapes.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::bed {

namespace {

dem::Template compound(const geom::Piece& whole, int parts) {
  // Slices of the core, each swept by the sphere of the whole: their union is the same stone, so
  // its mass and its sieve size are exact.
  std::vector<geom::Piece> pieces;
  for (const geom::Convex& part : geom::sliced(whole.core, parts))
    pieces.push_back({part, whole.radius});
  return geom::template_of(pieces, geom::piece_solid(whole), geom::smallest_hole({whole}));
}

// Spheres fill the rounded surface; inside the core alone they would be too small.
dem::Template filled(const geom::Piece& whole, int spheres) {
  const auto made = geom::spheres_filling(whole, spheres);
  return geom::template_of(balls(made), geom::union_solid(made, union_columns),
                           geom::smallest_hole(made));
}

// Evenly distributed over the templates, ends included.
int spheres_of(const std::vector<double>& range, std::int64_t k, std::int64_t shapes) {
  const auto least = static_cast<std::int64_t>(range[0]);
  const auto kinds = static_cast<std::int64_t>(range[1]) - least + 1;
  return static_cast<int>(least + k * kinds / shapes);
}

}  // namespace

void PolyhedronParameters::declare(input::Section& s) {
  s.integer("vertices", vertices, {.at_least = 6, .at_most = 200},
            "Number n of corners of a stone, which has 2 n - 4 triangular faces.");
  constexpr double most = 0.995;  // the largest value that stretching of many corners attains
  s.number("elongation", elongation, {.above = 0, .at_most = most},
           "Elongation I/L (width/length) of the stone, rounding included, measured by "
           "callipers: the thickness S is the smallest distance of parallel jaws, the width I the "
           "smallest distance at right angles to S, the length L the distance at right angles to "
           "both. Above about 0.95 there may be no such stone.");
  s.number("flatness", flatness, {.above = 0, .at_most = most},
           "Flatness S/I (thickness/width) of the stone, measured like the elongation.");
  s.number(
      "spread", spread, {.at_least = 0, .at_most = 0.5},
      "Half-width of the uniform distributions of elongation and flatness over the shapes, whose "
      "samples are limited to 0.1 to 0.95 (example: with elongation 0.85 and spread 0.23, 28 % of "
      "the stones receive 0.95); 0: all shapes have exactly the specified proportions.");
  s.number("angularity", angularity, {.at_least = 0, .at_most = 1},
           "Angularity; 0: corners evenly distributed over an ellipsoid; 1: most angular, with "
           "corners concentrated at few main corners.");
  s.number("rounding", rounding, {.above = 0, .at_most = 0.2},
           "Radius of edges and corners divided by the diameter of the sphere of equal volume; the "
           "volume is kept.");
  s.integer("pieces", pieces, {.at_least = 2, .at_most = 100},
            "Number of convex pieces of equal volume into which a stone is cut (compound).");
  s.numbers("spheres", spheres, {.at_least = 1, .at_most = 200},
            "Smallest and largest number of spheres in a stone; the shapes cover this range evenly "
            "(clump).",
            2);
  s.rule("spheres", spheres.size() == 2 && spheres[0] <= spheres[1],
         "must be two numbers, of which the second is not below the first");
}

// The seed of template k is a hash of both, so that a larger number of shapes does not change the
// existing polyhedra.
dem::Template polyhedron_shape(const BedParameters& parameters, std::int64_t k) {
  const PolyhedronParameters& p = parameters.polyhedron;
  const std::uint64_t seed =
      mix(static_cast<std::uint64_t>(parameters.seed) ^ mix(static_cast<std::uint64_t>(k)));
  const geom::Piece whole = geom::rounded_stone(
      {p.elongation, p.flatness, p.angularity, static_cast<int>(p.vertices), p.spread}, p.rounding,
      seed);
  if (parameters.stone == StoneKind::compound) return compound(whole, static_cast<int>(p.pieces));
  if (parameters.stone == StoneKind::clump)
    return filled(whole, spheres_of(p.spheres, k, parameters.shapes));
  return geom::template_of({whole});
}

dem::Template polyhedron_stone(const BedParameters& parameters, std::int64_t k) {
  try {
    return polyhedron_shape(parameters, k);
  } catch (const std::invalid_argument& why) {
    throw InputError({fmt::format("{}.polyhedron: no stone can be generated: {}",
                                  parameters.section, why.what())});
  }
}

}  // namespace trackbed::bed
