// Solid bodies: small elastic boxes of 8-node hexahedra that may move freely and are joined by
// pads. They model sleepers and rails as solids. Stones touch them through surfaces, as they touch
// everything else.
//
// Small displacements are assumed: strains and lever arms of forces are those of the undeformed
// shape. Every rank holds and solves all bodies, so no messages are sent and results are bitwise
// identical on any number of ranks. docs/decisions/solid_track.md.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/io/fields.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

// A box of equal elements. Mass-proportional damping of its solid is not used; a negative
// stiffness-proportional damping means none.
struct Body {
  std::string name;
  Vec3 low = Vec3::Zero(), high = Vec3::Ones();  // m, as built
  std::array<std::int64_t, 3> elements{1, 1, 1};
  Elastic solid;
  bool touched = false;  // by stones: then it has a surface
};

// A rectangle on the lower or upper face of a body, m as built.
enum class Side { lower, upper };
struct Patch {
  std::array<double, 2> x, y;
};

// Springs and dashpots, distributed evenly over a rectangle in which the upper face of one body and
// the lower face of another are opposite to each other.
struct Pad {
  std::size_t below, above;  // indices of bodies
  Patch patch;
  Vec3 stiffness = Vec3::Zero(), damping = Vec3::Zero();  // N/m, N s/m of the whole pad
};

// Displacement components that are fixed to 0 on a face normal to x or y.
struct HeldFace {
  std::size_t body;
  int axis;  // 0 or 1
  bool low;  // the face at the body's low end
  std::array<bool, 3> components;
};

struct BodiesParameters {
  std::vector<Body> bodies;
  std::vector<Pad> pads;
  std::vector<HeldFace> held;
  double alpha = -0.1;  // of Bossak's scheme (alpha_scheme.hpp), -1/3 to 0
};

// Nodes with weights that sum to 1: the mean over a part of a face.
struct NodeWeight {
  std::int32_t node;
  double weight;
};
using NodeWeights = std::vector<NodeWeight>;

// Rigid-body motion of a body: that of its centre of mass, and the rotation and spin that carry its
// angular momentum (rotation vector, rad; rad/s).
struct BodyMotion {
  Vec3 displacement, velocity, acceleration, rotation, spin;
};

struct BodiesTotals {
  std::int64_t elements = 0, unknowns = 0, factor = 0;  // entries of the triangular factor
  double kinetic = 0, elastic = 0;                      // J, pads included
};

class Bodies {
 public:
  explicit Bodies(const BodiesParameters& parameters);
  ~Bodies();
  Bodies(Bodies&&) noexcept;

  std::size_t count() const;            // of bodies
  double mass(std::size_t body) const;  // kg
  Vec3 centre(std::size_t body) const;  // m, as built
  // Resets all bodies to the undeformed shape without velocity, with the origin at `origin`.
  void place(const Vec3& origin);
  Vec3 origin() const;

  std::vector<Surface>& surfaces();  // of touched bodies in their order, normals outwards
  // Sets the surfaces to the present position of the bodies, without motion, until the next
  // `advance`.
  void show_at_rest();

  // Weights of the mean over a rectangle, or of the shape functions if it is a point. Parts of the
  // rectangle beyond the face are moved to the edge of the face.
  NodeWeights over(std::size_t body, Side side, const Patch& patch) const;
  struct PatchLoad {
    NodeWeights at;
    Vec3 force;  // N, at the end of the step
  };
  // One implicit step of Bossak's scheme (second order) under weight, loads and mean forces on the
  // nodes of the surfaces (one list per surface; empty: none). The first step after `place` starts
  // with the acceleration due to its forces. Sets position and motion of the surfaces. Factorises
  // the matrix if dt differs from that of the last step. Throws RunError if the matrix cannot be
  // factorised.
  void advance(double dt, double gravity, std::span<const PatchLoad> loads,
               const std::vector<std::span<const Vec3>>& node_force);

  // Adds loads at the end of the last step, as if `advance` had been called with them.
  void add_loads(std::span<const PatchLoad> loads);
  // m/s per N, upwards: velocity of `of` at the end of a step due to a unit load on `by`. A
  // displacement integrated from the velocities by the trapezoidal rule has the compliance dt/2
  // times this. Factorises as `advance` does.
  double mobility(double dt, const NodeWeights& of, const NodeWeights& by);
  double mobility(double dt, const NodeWeights& at) { return mobility(dt, at, at); }

  Vec3 displacement(const NodeWeights& at) const;  // m
  Vec3 velocity(const NodeWeights& at) const;      // m/s
  // m: the displacement integrated from the velocities by the trapezoidal rule in steps of dt; it
  // differs from `displacement` by dt^2 alpha^2/4 times the acceleration. With this displacement a
  // spring to a part that is integrated by that rule elsewhere creates no energy, for any dt
  // (docs/decisions/train_on_bed.md).
  Vec3 trapezoidal(double dt, const NodeWeights& at) const;
  BodyMotion motion(std::size_t body) const;
  Vec3 pad_force(std::size_t pad) const;  // N, on the body above, positive upwards
  // Pa, xx yy zz xy yz zx, tension positive, at a point of the undeformed body; on the border
  // between elements the mean of the adjacent elements.
  std::array<double, 6> stress(std::size_t body, const Vec3& place) const;
  BodiesTotals totals() const;
  std::size_t memory() const;  // bytes on this rank, without the triangular factor
  // Describes a body that is not a number or has rotated further than small displacements allow; or
  // empty.
  std::string trouble() const;

  // All elements, on rank 0 of `comm`, with displacement, velocity, stress and body. Local.
  io::Grid fields(const par::Comm& comm) const;
  void archive(io::Archive& a);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::fem
