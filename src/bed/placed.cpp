// Parameters of single stones and of surfaces, each declared once.
//
// Bounds and rules here concern one table; relations between tables are checked where all of them
// are available.
#include "trackbed/bed/placed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>

namespace trackbed::bed {

namespace {

const std::vector<std::string_view> shape_words = {"ball",       "block",    "clump",   "hull",
                                                   "polyhedron", "compound", "library", "mesh"};

std::string_view word_of(ShapeKind kind) { return shape_words[static_cast<std::size_t>(kind)]; }

constexpr const char* meaning_of_axis =
    "Axis of the rotation by `angle`, a vector of any length; the rotation is counter-clockwise if "
    "seen from the tip of the axis.";

void declare_turn(std::vector<double>& axis, double& angle, input::Section& s) {
  s.numbers("axis", axis, {.unit = "-"}, meaning_of_axis, 3);
  s.number("angle", angle, {.unit = "degrees"}, "Angle of the rotation about `axis`.");
  s.rule("axis", axis.size() != 3 || vector_of(axis).norm() > 0, "must not be zero");
}

bool are_spheres(const std::vector<double>& spheres) {
  bool radii = spheres.size() % 4 == 0;
  for (std::size_t k = 3; k < spheres.size(); k += 4) radii = radii && spheres[k] > 0;
  return radii;
}

// Randomly generated kinds, which have no size of their own.
bool is_drawn(const ShapeParameters& p) {
  return p.shape == ShapeKind::polyhedron || p.shape == ShapeKind::compound ||
         (p.shape == ShapeKind::clump && p.spheres.empty());
}

// Compared with the defaults: an omitted value and a repeated default are the same.
void declare_idle_of_shape(const ShapeParameters& p, input::Section& s) {
  using enum ShapeKind;
  const ShapeParameters usual;
  const auto of = [&](std::initializer_list<ShapeKind> kinds) {
    return std::find(kinds.begin(), kinds.end(), p.shape) != kinds.end();
  };
  const auto idle = [&](const char* key, bool acts, bool given) {
    s.rule(key, acts || !given,
           fmt::format("has no effect with shape = \"{}\"; leave it out", word_of(p.shape)),
           {.reads = {"shape", key}});
  };
  const bool drawn = is_drawn(p), pieces = of({compound, mesh});
  idle("radius", of({ball}), p.radius != usual.radius);
  idle("sides", of({block}), !p.sides.empty());
  idle("corners", of({hull}), !p.corners.empty());
  idle("rounding", of({block, hull}), p.rounding != usual.rounding);
  idle("spheres", of({clump}), !p.spheres.empty());
  idle("seed", drawn, p.seed != usual.seed);
  idle("file", of({library, mesh}), !p.file.empty());
  idle("entry", of({library}), !p.entry.empty());
  idle("unit", of({mesh}), p.unit != usual.unit);
  const PolyhedronParameters &own = p.polyhedron, &none = usual.polyhedron;
  idle("polyhedron.vertices", drawn || of({mesh}), own.vertices != none.vertices);
  idle("polyhedron.rounding", drawn || of({mesh}), own.rounding != none.rounding);
  idle("polyhedron.elongation", drawn, own.elongation != none.elongation);
  idle("polyhedron.flatness", drawn, own.flatness != none.flatness);
  idle("polyhedron.spread", drawn, own.spread != none.spread);
  idle("polyhedron.angularity", drawn, own.angularity != none.angularity);
  idle("polyhedron.pieces", pieces, own.pieces != none.pieces);
  idle("polyhedron.spheres", drawn && of({clump}), own.spheres != none.spheres);
}

void declare_rules_of_shape(const ShapeParameters& p, input::Section& s) {
  const bool block = p.shape == ShapeKind::block, hull = p.shape == ShapeKind::hull;
  const bool filed = p.shape == ShapeKind::library || p.shape == ShapeKind::mesh;
  s.rule("sides", !block || p.sides.size() == 3, "must be three lengths for a block");
  bool wide = true;
  for (const double side : p.sides) wide = wide && side > 2 * p.rounding;
  s.rule("sides", !block || wide,
         fmt::format("must each be above {:g} m, twice the rounding", 2 * p.rounding));
  constexpr std::size_t fewest = 12;  // a tetrahedron
  s.rule("corners", !hull || (p.corners.size() >= fewest && p.corners.size() % 3 == 0),
         "must list x, y, z of at least four corners for a hull");
  s.rule("spheres", are_spheres(p.spheres),
         "must list x, y, z and a radius above 0 for each sphere");
  s.rule(
      "file", !filed || !p.file.empty(),
      p.shape == ShapeKind::mesh
          ? "must name a mesh (.stl, .ply or .obj)"
          : "must name a library of shapes; `trackbed shapes scan.stl --library FILE` creates one");
  s.rule("size", !is_drawn(p) || p.size > 0, "must be above 0 m for a randomly generated stone");
  s.rule("size", p.size == 0 || is_drawn(p) || filed,
         "is only for generated stones, libraries and meshes; leave it out, as the lengths define "
         "this shape");
}

}  // namespace

void ShapeParameters::declare(input::Section& s) {
  s.choice("shape", shape, shape_words,
           "Shape of the stone; ball: sphere (disk in a plane model); block: cuboid; clump: "
           "rigidly joined spheres (disks in a plane model); hull: convex hull of corners; "
           "polyhedron: randomly generated and irregular; compound: such a polyhedron cut into "
           "convex pieces; library: one of a file of shapes; mesh: a closed mesh, in convex "
           "pieces. All but ball and clump are for three-dimensional models only.");
  s.number("radius", radius, {.unit = "m", .above = 0, .usually_from = 1e-5, .usually_to = 1},
           "Radius of the ball.");
  s.numbers("sides", sides, {.unit = "m", .above = 0},
            "Overall lengths along x, y, z, rounding included (block).");
  s.numbers("corners", corners, {.unit = "m"}, "x, y, z of each corner before rounding (hull).");
  s.number("rounding", rounding, {.unit = "m", .above = 0, .usually_to = 0.1},
           "Radius of edges and corners; block: the faces keep their positions; hull: the volume "
           "is kept (docs/shapes.md).");
  s.numbers("spheres", spheres, {.unit = "m"},
            "x, y, z, radius of each sphere (clump); none: a generated polyhedron filled with "
            "spheres. A plane model ignores y.");
  s.table("polyhedron", polyhedron,
          "Randomly generated stones, as in a bed. A mesh uses only `rounding`, `pieces` (largest "
          "number) and `vertices` (largest number, of each piece).");
  s.integer("seed", seed, {.at_least = 0},
            "Seed of the random numbers; another seed gives another stone.");
  s.file("file", file, "Mesh (.stl, .ply, .obj) or library of shapes.", input::FileRole::origin);
  s.text("entry", entry,
         "Name of the shape in its library; it may be omitted if the library has only one shape.");
  s.number("unit", unit, {.unit = "m", .above = 0}, "Length unit of the mesh.");
  s.number("size", size, {.unit = "m", .at_least = 0, .usually_from = 1e-4, .usually_to = 1},
           "Size of the stone: smallest square hole that it passes (generated, library, mesh); 0: "
           "as in the file.");
  declare_rules_of_shape(*this, s);
  declare_idle_of_shape(*this, s);
}

void StoneParameters::declare(input::Section& s) {
  s.text("name", name, "Name of the stone in histories, messages and overrides.", {}, true);
  ShapeParameters::declare(s);
  s.text("material", material, "Contact material of the stone, which defines its density.");
  s.choice("motion", motion, {"free", "fixed", "driven"},
           "Motion of the stone; free: moved by forces; fixed: at rest; driven: constant velocity "
           "and spin, independent of the forces.");
  s.numbers("position", position, {.unit = "m"}, "Position of the centre of mass.", 3);
  declare_turn(axis, angle, s);
  s.numbers("velocity", velocity, {.unit = "m/s"}, "Initial velocity of the centre of mass.", 3);
  s.numbers("spin", spin, {.unit = "rad/s", .usually_from = -1e4, .usually_to = 1e4},
            "Initial angular velocity in space axes.", 3);
  s.rule(
      "motion",
      motion != MotionKind::fixed || (vector_of(velocity).isZero(0) && vector_of(spin).isZero(0)),
      "needs velocity and spin of zero; use driven for a constant motion",
      {.reads = {"motion", "velocity", "spin"}});
}

void PlateParameters::declare(input::Section& s) {
  s.text("name", name, "Name of the plate in histories, messages and overrides.", {}, true);
  s.text("material", material, "Contact material of the plate.");
  s.numbers("centre", centre, {.unit = "m"}, "Centre of the plate at time 0.", 3);
  s.numbers("normal", normal, {.unit = "-"},
            "Normal of the plate towards the stones, of any length; a stone that reaches the plate "
            "from behind ends the run.",
            3);
  s.numbers("size", size, {.unit = "m", .above = 0},
            "Side lengths of the plate; a plane model uses only the first.", 2);
  s.numbers("edge", edge, {.unit = "-"},
            "Direction of the first side of the plate; its component along the normal is ignored; "
            "zero: x, or y if the normal is along x (space).",
            3);
  s.numbers("velocity", velocity, {.unit = "m/s"},
            "Velocity of the plate, constant and independent of the forces.", 3);
  const Vec3 n = vector_of(normal), e = vector_of(edge);
  s.rule("normal", normal.size() != 3 || n.norm() > 0, "must not be zero");
  constexpr double least = 1e-6;  // sine of the angle between both
  s.rule("edge", n.cross(e).norm() >= least * n.norm() * e.norm(), "must not be along the normal",
         {.reads = {"edge", "normal"}});
}

void BoxParameters::declare(input::Section& s) {
  s.text("name", name, "Name of the box in histories, messages and overrides.", {}, true);
  s.text("material", material, "Contact material of the box.");
  s.numbers("low", low, {.unit = "m"},
            "Corner of the box with smallest x, y, z, before the rotation about its centre.", 3);
  s.numbers("high", high, {.unit = "m"},
            "Corner of the box with largest x, y, z, before the rotation about its centre.", 3);
  s.choice("side", side, {"inside", "outside"},
           "Side on which the stones are; inside: a container; outside: a body. In a plane model "
           "the box has no faces normal to y.");
  declare_turn(axis, angle, s);
  s.numbers("velocity", velocity, {.unit = "m/s"},
            "Velocity of the box, constant and independent of the forces.", 3);
  s.rule("high",
         low.size() != 3 || high.size() != 3 || (vector_of(high) - vector_of(low)).minCoeff() > 0,
         fmt::format("must be above `low` in x, y and z (low = [{:g}] m)", fmt::join(low, ", ")),
         {.reads = {"low", "high"}});
}

Quat turn_of(const std::vector<double>& axis, double angle) {
  const Vec3 about = vector_of(axis);
  if (angle == 0 || !(about.norm() > 0)) return Quat::Identity();
  return Quat(Eigen::AngleAxisd(angle * std::numbers::pi / 180, about.normalized()));
}

}  // namespace trackbed::bed
