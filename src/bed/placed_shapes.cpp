// Shapes of single stones, from what beds and `trackbed shapes` make theirs of.
//
// Blocks, hulls and clumps have the size their lengths say; what is drawn or comes from a file is
// scaled to its sieve size. A template lies in its principal axes; the turn back to the axes that a
// user described it in goes along, so that attitudes mean what the deck means by them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "shapes.hpp"
#include "trackbed/bed/library.hpp"
#include "trackbed/bed/placed.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::bed {

namespace {

constexpr int cells = 192;  // columns across a union of spheres

// Mass and inertia are exact for one piece.
PlacedShape shape_of(const geom::Piece& piece, double sieve) {
  const geom::Solid solid = geom::piece_solid(piece);
  return {geom::template_of({piece}, solid, sieve), 1, solid.axes};
}

// m, the square hole that a cuboid passes along its longest side: with the middle side along one of
// the hole's, or with both shorter ones along its diagonals, where rounding counts. (The general
// search takes seconds for bodies with so many equal views.)
double hole_of_block(std::vector<double> sides, double rounding) {
  std::sort(sides.begin(), sides.end());
  const double core = sides[0] + sides[1] - 4 * rounding;
  return std::min(sides[1], core / std::numbers::sqrt2 + 2 * rounding);
}

// The core is smaller by the rounding on all sides, so that faces lie where the sides say.
PlacedShape block(const ShapeParameters& p) {
  const Vec3 half = vector_of(p.sides) / 2 - Vec3::Constant(p.rounding);
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(half.cwiseProduct(
        Vec3((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1)));
  return shape_of({geom::convex_hull(corners), p.rounding}, hole_of_block(p.sides, p.rounding));
}

PlacedShape hull(const ShapeParameters& p) {
  std::vector<Vec3> corners;
  for (std::size_t k = 0; k + 2 < p.corners.size(); k += 3)
    corners.emplace_back(p.corners[k], p.corners[k + 1], p.corners[k + 2]);
  const geom::Convex core = geom::convex_hull(corners);
  constexpr std::size_t fewest = 4;  // faces of a body; a flat one has two, back to back
  if (core.faces.size() < fewest)
    throw InputError({"corners: lie in one plane and enclose nothing: give at least four that do"});
  const double volume = geom::piece_solid({core, 0}).volume;
  const double largest = std::cbrt(3 * volume / (4 * std::numbers::pi));
  if (p.rounding > largest)
    throw InputError(
        {fmt::format("rounding: {:g} m is the radius of a ball larger than the hull of "
                     "{:.3g} m^3; it must be below {:.3g} m",
                     p.rounding, volume, largest)});
  const geom::Piece piece = geom::rounded(core, p.rounding);
  return shape_of(piece, geom::smallest_hole({piece}));
}

PlacedShape clump(const ShapeParameters& p, Dimension dimension) {
  const bool plane = dimension == Dimension::plane;
  std::vector<geom::Sphere> spheres;
  for (std::size_t k = 0; k + 3 < p.spheres.size(); k += 4)
    spheres.push_back(
        {Vec3(p.spheres[k], plane ? 0 : p.spheres[k + 1], p.spheres[k + 2]), p.spheres[k + 3]});
  const geom::Solid solid = plane ? geom::union_lamina(spheres) : geom::union_solid(spheres, cells);
  const double sieve = plane ? geom::smallest_slot(spheres) : geom::smallest_hole(spheres);
  return {geom::template_of(balls(spheres), solid, sieve), 1, solid.axes};
}

// The first stone of a bed of that kind and seed.
PlacedShape drawn(const ShapeParameters& p) {
  BedParameters bed;
  bed.stone = p.shape == ShapeKind::polyhedron ? StoneKind::polyhedra
              : p.shape == ShapeKind::compound ? StoneKind::compound
                                               : StoneKind::clump;
  bed.polyhedron = p.polyhedron, bed.seed = p.seed, bed.shapes = 1;
  return {polyhedron_shape(bed, 0), 1, Quat::Identity()};
}

PlacedShape of_library(const par::Comm& comm, const ShapeParameters& p) {
  const std::vector<NamedShape> shapes = load_library(comm, p.file);
  std::vector<std::string> names;
  for (const NamedShape& shape : shapes) names.push_back(shape.name);
  if (p.entry.empty() && shapes.size() == 1) return {shapes[0].shape, 1, Quat::Identity()};
  const auto found = std::find(names.begin(), names.end(), p.entry);
  if (found == names.end()) {
    const std::string near = p.entry.empty() ? "" : input::nearest(p.entry, names);
    const std::size_t count = names.size();
    names.resize(std::min<std::size_t>(count, 10));
    const std::string known =
        fmt::format("there {} {}{}", count == 1 ? "is" : "are", fmt::join(names, ", "),
                    count > names.size() ? fmt::format(" and {} more", count - names.size()) : "");
    throw InputError({fmt::format(
        "entry: {}; {}",
        p.entry.empty() ? fmt::format("must name one of the {} shapes of {}", count, p.file)
                        : fmt::format("{} has no shape \"{}\"", p.file, p.entry),
        near.empty() ? known : fmt::format("did you mean {}?", near))});
  }
  const NamedShape& shape = shapes[static_cast<std::size_t>(found - names.begin())];
  for (const geom::Piece& piece : shape.shape.pieces)
    if (!(piece.radius > 0))
      throw InputError({fmt::format("entry: {} has edges without rounding", p.entry)});
  return {shape.shape, 1, Quat::Identity()};
}

PlacedShape of_mesh(const par::Comm& comm, const ShapeParameters& p) {
  const NamedShape made = shape_of_mesh(comm, p.file,
                                        {.unit = p.unit,
                                         .pieces = static_cast<int>(p.polyhedron.pieces),
                                         .vertices = static_cast<int>(p.polyhedron.vertices),
                                         .rounding = p.polyhedron.rounding});
  return {made.shape, 1, made.axes};
}

PlacedShape made(const par::Comm& comm, const ShapeParameters& p, Dimension dimension) {
  switch (p.shape) {
    case ShapeKind::ball:
      return {round_stone(dimension), 2 * p.radius, Quat::Identity()};
    case ShapeKind::block:
      return block(p);
    case ShapeKind::hull:
      return hull(p);
    case ShapeKind::clump:
      return p.spheres.empty() ? drawn(p) : clump(p, dimension);
    case ShapeKind::library:
      return of_library(comm, p);
    case ShapeKind::mesh:
      return of_mesh(comm, p);
    default:
      return drawn(p);
  }
}

}  // namespace

PlacedShape placed_shape(const par::Comm& comm, const ShapeParameters& parameters,
                         Dimension dimension) {
  try {
    PlacedShape placed = made(comm, parameters, dimension);
    if (parameters.size > 0) placed.scale = parameters.size / placed.shape.sieve;
    return placed;
  } catch (const std::invalid_argument& why) {
    throw InputError({fmt::format("shape: cannot be made: {}", why.what())});
  } catch (const InputError& why) {  // of a file, which is what its sentence begins with
    const std::string words = why.what();
    if (parameters.file.empty() || !words.starts_with(parameters.file)) throw;
    throw InputError({"file: " + words});
  }
}

}  // namespace trackbed::bed
