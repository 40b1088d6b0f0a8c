// Small elastic bodies that are free to move as a whole: boxes of 8-node hexahedra joined by pads.
// Sleepers and rails as solids. Stones touch them through surfaces, as they touch everything.
//
// Small displacements: strains, and arms of forces, are those of the shape as built. Every rank
// holds and solves all of it alike, so that nothing is sent: the same bits on any number of ranks.
// docs/decisions/solid_track.md.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/fields.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

// A box of equal elements. Its solid's damping by mass is not used; below 0, by stiffness: none.
struct Body {
  std::string name;
  Vec3 low = Vec3::Zero(), high = Vec3::Ones();  // m, as built
  std::array<std::int64_t, 3> elements{1, 1, 1};
  Elastic solid;
  bool touched = false;  // by stones: it has a surface
};

// A rectangle on the lower or upper face of a body, m as built.
enum class Side { lower, upper };
struct Patch {
  std::array<double, 2> x, y;
};

// Springs and dashpots, spread evenly over a rectangle in which the upper face of one body and the
// lower face of another lie opposite to each other.
struct Pad {
  std::size_t below, above;  // numbers of bodies
  Patch patch;
  Vec3 stiffness = Vec3::Zero(), damping = Vec3::Zero();  // N/m, N s/m of all of it
};

// Components of the displacement that are 0 on a face normal to x or y.
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

// Nodes with weights that sum to 1: a mean over a part of a face.
struct NodeWeight {
  std::int32_t node;
  double weight;
};
using NodeWeights = std::vector<NodeWeight>;

// A body's motion as a whole: of its centre of mass, and rotation and spin that carry its angular
// momentum (rotation vector, rad; rad/s).
struct BodyMotion {
  Vec3 displacement, velocity, acceleration, rotation, spin;
};

struct BodiesTotals {
  std::int64_t elements = 0, unknowns = 0, factor = 0;  // numbers in the triangular factor
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
  // Puts all of it, as built and at rest, with the origin at `origin`.
  void place(const Vec3& origin);
  Vec3 origin() const;

  std::vector<Surface>& surfaces();  // of touched bodies in their order, normals outwards
  // Surfaces where the bodies are now, without motion, until the next `advance`.
  void show_at_rest();

  // The mean over a rectangle, or where it is a point the shape functions there. What reaches
  // beyond the face counts at its edge.
  NodeWeights over(std::size_t body, Side side, const Patch& patch) const;
  struct Push {
    NodeWeights at;
    Vec3 force;  // N, at the end of the step
  };
  // One implicit step: Bossak's scheme, second order, under weight, pushes and mean forces on the
  // nodes of the surfaces (of each surface; empty: none). The first step after `place` begins with
  // the acceleration that its forces make. Fills position and motion of the surfaces. Factorises
  // when dt is another than last time. Throws RunError if the matrix cannot be factorised.
  void advance(double dt, double gravity, std::span<const Push> pushes,
               const std::vector<std::span<const Vec3>>& node_force);

  // More pushes at the end of the step that `advance` took last, as if it had had them.
  void push(std::span<const Push> pushes);
  // m/s per N, up: how fast `of` moves at the end of a step because of a push at `by`. What follows
  // the velocities by the trapezoidal rule gives way by dt/2 of it. Factorises as `advance`.
  double mobility(double dt, const NodeWeights& of, const NodeWeights& by);
  double mobility(double dt, const NodeWeights& at) { return mobility(dt, at, at); }

  Vec3 displacement(const NodeWeights& at) const;  // m
  Vec3 velocity(const NodeWeights& at) const;      // m/s
  // m: the displacement that follows the velocities by the trapezoidal rule in steps of dt; from
  // the other by dt^2 alpha^2/4 of the acceleration. A spring on it to a part that somebody else
  // moves by that rule makes no energy, whatever dt is (docs/decisions/train_on_bed.md).
  Vec3 trapezoidal(double dt, const NodeWeights& at) const;
  BodyMotion motion(std::size_t body) const;
  Vec3 pad_force(std::size_t pad) const;  // N, on the body above; pushing it up is positive
  // Pa, xx yy zz xy yz zx, tension positive, at a point of the body as built; between elements the
  // mean of those around it.
  std::array<double, 6> stress(std::size_t body, const Vec3& place) const;
  BodiesTotals totals() const;
  std::size_t memory() const;  // bytes on this rank, without the factor
  // What is no number any more, or has turned further than small displacements allow; or empty.
  std::string trouble() const;

  // All elements, on rank 0 of `comm`, with displacement, velocity, stress and body. Local.
  io::Grid fields(const par::Comm& comm) const;
  // All ranks hold the same state; rank 0 of `comm` writes it, all read it. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  void load(const io::File& file, const std::string& group);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::fem
