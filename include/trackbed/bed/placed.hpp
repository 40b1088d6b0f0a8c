// Single stones and rigid surfaces, each placed by a deck, for experiments with few bodies.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trackbed/bed/bed.hpp"
#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/geom/convex.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::bed {

enum class ShapeKind { ball, block, clump, hull, polyhedron, compound, library, mesh };

// The shape and size of a stone.
struct ShapeParameters {
  ShapeKind shape = ShapeKind::ball;
  double radius = 0.02;              // m, ball
  std::vector<double> sides = {};    // m, block
  std::vector<double> corners = {};  // m, x y z of each, hull
  double rounding = 1e-3;            // m, block and hull
  std::vector<double> spheres = {};  // m, x y z radius of each, clump; none: a filled polyhedron
  PolyhedronParameters polyhedron;   // polyhedron, compound, mesh, filled polyhedron
  std::int64_t seed = 1;             // of randomly generated shapes
  std::string file, entry;           // mesh, library; name in the library
  double unit = 1;                   // m per unit of a mesh
  double size = 0;                   // m, smallest square hole it passes; 0: as in the file
  void declare(input::Section& s);
  bool operator==(const ShapeParameters&) const = default;
};

enum class MotionKind { free, fixed, driven };

struct StoneParameters : ShapeParameters {
  std::string name;
  std::string material = "ballast";
  MotionKind motion = MotionKind::free;
  std::vector<double> position = {0, 0, 0};  // m, of the centre of mass
  std::vector<double> axis = {0, 1, 0};      // rotated about it ...
  double angle = 0;                          // ... by this angle, degrees
  std::vector<double> velocity = {0, 0, 0};  // m/s
  std::vector<double> spin = {0, 0, 0};      // rad/s, in space axes
  void declare(input::Section& s);
};

// A rectangle that stones touch on the side its normal points to.
struct PlateParameters {
  std::string name;
  std::string material = "ballast";
  std::vector<double> centre = {0, 0, 0};    // m
  std::vector<double> normal = {0, 0, 1};    // of any length
  std::vector<double> size = {1, 1};         // m
  std::vector<double> edge = {0, 0, 0};      // direction of the first side; zero: automatic
  std::vector<double> velocity = {0, 0, 0};  // m/s
  void declare(input::Section& s);
};

enum class BoxSide { inside, outside };

// A closed box: a container, or a body that stones touch from outside.
struct BoxParameters {
  std::string name;
  std::string material = "ballast";
  std::vector<double> low = {-0.5, -0.5, -0.5}, high = {0.5, 0.5, 0.5};  // m
  BoxSide side = BoxSide::inside;
  std::vector<double> axis = {0, 1, 0};      // rotated about its centre ...
  double angle = 0;                          // ... by this angle, degrees
  std::vector<double> velocity = {0, 0, 0};  // m/s
  void declare(input::Section& s);
};

inline Vec3 vector_of(const std::vector<double>& values) {
  return values.size() == 3 ? Vec3(values[0], values[1], values[2]) : Vec3(Vec3::Zero());
}
// The rotation by `angle` degrees about `axis`, which may have any length.
Quat turn_of(const std::vector<double>& axis, double angle);

// A template, its scale and its orientation.
struct PlacedShape {
  dem::Template shape;
  double scale = 1;
  Quat axes = Quat::Identity();  // from its principal axes to those of its description
};
// Throws InputError, with a sentence that begins with the name of the parameter, if the stone
// cannot be generated. Collective.
PlacedShape placed_shape(const par::Comm& comm, const ShapeParameters& parameters,
                         Dimension dimension);

// Plates and boxes with constant velocities. All ranks hold the same.
class PlacedSurfaces {
 public:
  // In a plane model all extend across `thickness`, m.
  PlacedSurfaces(const std::vector<PlateParameters>& plates,
                 const std::vector<BoxParameters>& boxes, const dem::Physics& physics,
                 Dimension dimension, double thickness);
  // Sets the positions at `time`, s, and the displacements in the window of length dt that begins
  // then.
  void update(double time, double dt);
  std::vector<Surface>& surfaces() { return surfaces_; }
  const std::vector<Surface>& surfaces() const { return surfaces_; }
  const Vec3& velocity(std::size_t surface) const { return velocity_[surface]; }  // m/s

 private:
  void add(Surface surface, const std::vector<double>& velocity);

  std::vector<Surface> surfaces_;
  std::vector<std::vector<Vec3>> initial_;  // m, nodes at time 0
  std::vector<Vec3> velocity_;
};

// The pieces of a stone at its position in the deck.
std::vector<geom::Piece> pieces_in_space(const PlacedShape& shape, const StoneParameters& stone);
// m, depth of the pieces within a surface that intersects their cores, or within a box that
// encloses them: the displacement that would free them, rounding included. 0 in all other cases,
// which contacts detect.
double penetration_depth(const std::vector<geom::Piece>& pieces, const Surface& surface);

// Whether a point is behind a plate or wall, or inside a box that is touched from outside.
bool is_behind(const Vec3& point, const Surface& surface);

// The first surface that a stone in free flight reaches within `until` s. Surfaces have the
// positions of the last `update`. The rotation of the stone is neglected.
struct Flight {
  Vec3 velocity = Vec3::Zero();  // m/s
  double gravity = 0;            // m/s^2, along -z
};
struct Impact {
  std::size_t surface;
  double time;       // s
  bool from_behind;  // the side without contact
};
std::optional<Impact> first_impact(const std::vector<geom::Piece>& pieces, const Flight& flight,
                                   const PlacedSurfaces& placed, double until);

}  // namespace trackbed::bed
