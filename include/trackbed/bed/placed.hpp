// Single stones and rigid surfaces, each placed by a deck: what experiments are made of.
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

// The shape of a stone at its size.
struct ShapeParameters {
  ShapeKind shape = ShapeKind::ball;
  double radius = 0.02;              // m, ball
  std::vector<double> sides = {};    // m, block
  std::vector<double> corners = {};  // m, x y z of each, hull
  double rounding = 1e-3;            // m, block and hull
  std::vector<double> spheres = {};  // m, x y z radius of each, clump; none: a filled polyhedron
  PolyhedronParameters polyhedron;   // polyhedron, compound, mesh, filled polyhedron
  std::int64_t seed = 1;             // of what is drawn
  std::string file, entry;           // mesh, library; name in the library
  double unit = 1;                   // m per unit of a mesh
  double size = 0;                   // m, smallest square hole it passes; 0: as the file has it
  void declare(input::Section& s);
  bool operator==(const ShapeParameters&) const = default;
};

enum class MotionKind { free, fixed, driven };

struct StoneParameters : ShapeParameters {
  std::string name;
  std::string material = "ballast";
  MotionKind motion = MotionKind::free;
  std::vector<double> position = {0, 0, 0};  // m, of the centre of mass
  std::vector<double> axis = {0, 1, 0};      // turned about it ...
  double angle = 0;                          // ... by so many degrees
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
  std::vector<double> edge = {0, 0, 0};      // direction of the first side; zero: chosen
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
  std::vector<double> axis = {0, 1, 0};      // turned about its centre ...
  double angle = 0;                          // ... by so many degrees
  std::vector<double> velocity = {0, 0, 0};  // m/s
  void declare(input::Section& s);
};

inline Vec3 vector_of(const std::vector<double>& values) {
  return values.size() == 3 ? Vec3(values[0], values[1], values[2]) : Vec3(Vec3::Zero());
}
// A turn by `angle` degrees about `axis`, of any length.
Quat turn_of(const std::vector<double>& axis, double angle);

// A template and how a stone is made of it.
struct PlacedShape {
  dem::Template shape;
  double scale = 1;
  Quat axes = Quat::Identity();  // from its principal axes to those it was described in
};
// Throws InputError, with a sentence that begins with the name of the parameter, if there is no
// such stone. Collective.
PlacedShape placed_shape(const par::Comm& comm, const ShapeParameters& parameters,
                         Dimension dimension);

// Plates and boxes with the velocities they keep. All ranks hold the same.
class PlacedSurfaces {
 public:
  // In a plane model all reach across `thickness`, m.
  PlacedSurfaces(const std::vector<PlateParameters>& plates,
                 const std::vector<BoxParameters>& boxes, const dem::Physics& physics,
                 Dimension dimension, double thickness);
  // Where they are at `time` s, and their way in the window of length dt that begins there.
  void show(double time, double dt);
  std::vector<Surface>& surfaces() { return surfaces_; }
  const std::vector<Surface>& surfaces() const { return surfaces_; }
  const Vec3& velocity(std::size_t surface) const { return velocity_[surface]; }  // m/s

 private:
  void add(Surface surface, const std::vector<double>& velocity);

  std::vector<Surface> surfaces_;
  std::vector<std::vector<Vec3>> home_;  // m, nodes at time 0
  std::vector<Vec3> velocity_;
};

// The pieces of a stone as the deck places it.
std::vector<geom::Piece> pieces_in_space(const PlacedShape& shape, const StoneParameters& stone);
// m, how far they are within a surface that cuts their cores, or within a box that encloses them:
// the way out, rounding included. 0 where neither is so and contacts tell.
double depth_within(const std::vector<geom::Piece>& pieces, const Surface& surface);

// Whether a point is behind a plate or a wall, or in a box that is touched from outside.
bool is_behind(const Vec3& point, const Surface& surface);

// The surface that a stone in free flight reaches first within `until` s, where surfaces are as
// `show` placed them last. The stone does not turn.
struct Flight {
  Vec3 velocity = Vec3::Zero();  // m/s
  double gravity = 0;            // m/s^2, along -z
};
struct Reached {
  std::size_t surface;
  double time;       // s
  bool from_behind;  // where stones do not touch it
};
std::optional<Reached> reached_first(const std::vector<geom::Piece>& pieces, const Flight& flight,
                                     const PlacedSurfaces& placed, double until);

}  // namespace trackbed::bed
