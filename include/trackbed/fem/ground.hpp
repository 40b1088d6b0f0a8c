// The continuum below the bed, spread over ranks: layers of 8-node hexahedra, or 10-node tetrahedra
// that make an embankment of these layers or come from a mesh file.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/fields.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

struct Elastic {
  double young = 150e6, poisson = 0.35, density = 1850;  // Pa, -, kg/m^3
  double rayleigh_mass = -1, rayleigh_stiffness = -1;    // 1/s, s; below 0: the ground's
  void declare(input::Section& s);
};

enum class Yield { none, mohr_coulomb };

// What a solid can carry. Mohr-Coulomb's shear strength is c - sigma_n tan(phi); no hardening.
struct Strength {
  Yield yield = Yield::none;
  double cohesion = 10e3;                          // Pa
  double friction_angle = 30, dilation_angle = 0;  // degrees
  double tensile_strength = 0;                     // Pa
  void declare(input::Section& s);
};

// Horizontal layer, from the top down in the order of the deck.
struct Layer {
  std::string name;
  double thickness = 1;  // m
  Elastic solid;
  std::string young_file = {};  // Young's modulus along x instead of one number
  Strength strength = {};
  std::int64_t zones = 0;  // over its height; 0: its share of zones_z
  void declare(input::Section& s);
};

// A region cut out of the layers: elements whose centre lies in the outline take its solid; later
// blocks win over earlier ones. Structure, wedge, surface layer of the transition zone.
struct Block {
  std::string name;
  bool present = true;
  std::vector<double> outline;  // m, x and z of each corner in turn; z = 0 is the top
  Elastic solid;
  Strength strength = {};
  std::vector<double> y = {};  // m, from and to; empty: all of the ground's width
  void declare(input::Section& s);
};

// The outline of an embankment across the track at one place along it, symmetric about y = 0.
struct CrossSection {
  double x = 0;        // m
  double crest = 3;    // m, half of its width
  double height = 0;   // m, from the crest down to the natural ground; 0: that of its layers
  double slope = 1.5;  // of its sides: so many across, one up
  void declare(input::Section& s);
  double foot() const { return crest + slope * height; }  // m, half of its width below
};

// What the elements of a physical volume of a mesh file are made of.
struct MeshSolid {
  std::string name;  // of the physical volume
  Elastic solid;
  Strength strength = {};
  void declare(input::Section& s);
};

// What a physical surface of a mesh file is to the ground. Rollers hold along the normal; quiet
// ones are dashpots, with springs below a base.
enum class BorderKind { free, fixed, roller, quiet };
struct MeshBorder {
  std::string name;  // of the physical surface
  BorderKind holds = BorderKind::roller;
  void declare(input::Section& s);
};

enum class Integrator { explicit_, newmark, hht, bossak, generalized_alpha };
enum class PlaneState { stress, strain };
enum class Base { fixed, quiet };  // quiet: Lysmer & Kuhlemeyer 1969 dashpots
// Lateral borders. roller: held along the normal, which makes it a plane of symmetry; free_field:
// dashpots against columns that feel only what comes from below; as_sides: of a single side, what
// all have; periodic: one with the side opposite.
enum class Sides { free, roller, quiet, free_field, fixed, as_sides, periodic };

struct GroundParameters {
  bool present = true;
  std::string mesh;  // Gmsh file; then solids and borders count, and what makes zones does not
  std::string mesh_top = "top";  // physical surface below the stones
  std::vector<MeshSolid> solids;
  std::vector<MeshBorder> borders;
  std::vector<double> x = {0, 10};        // m, from and to
  std::vector<double> y = {-0.65, 0.65};  // m; a plane model takes its thickness from the model
  std::int64_t zones_x = 100, zones_y = 1, zones_z = 50;
  // Each zone is so many times as wide as its neighbour towards `fine`, m; 1: all alike.
  double ratio_x = 1, ratio_y = 1, fine_x = 0, fine_y = 0;
  std::vector<Layer> layers;
  std::vector<Block> blocks;
  std::vector<CrossSection> sections;  // of an embankment, linear between; its top is the crest
  std::int64_t embankment_layers = 0;  // of these layers, from the top down; natural ground below
  PlaneState plane = PlaneState::stress;
  Base base = Base::quiet;
  // Pa/m springs beside the dashpots of a quiet base: the ground below; 0: none; below 0: chosen,
  // as `base_spring` says.
  double base_stiffness = -1;
  Sides sides = Sides::roller;
  Sides side_x_low = Sides::as_sides, side_x_high = Sides::as_sides;
  Sides side_y_low = Sides::as_sides, side_y_high = Sides::as_sides;
  Sides side(int axis, bool high) const;  // normal to x (0) or y (1); never as_sides
  bool periodic(int axis) const { return side(axis, false) == Sides::periodic; }
  std::string base_motion;  // file: velocity of a wave that comes up through a quiet base
  double rayleigh_mass = 0, rayleigh_stiffness = 0;  // 1/s, s; of solids without their own
  Integrator integrator = Integrator::explicit_;
  double safety = 0.8;  // explicit step over the critical one
  double newmark_beta = 0.25, newmark_gamma = 0.5;
  double alpha = -0.1;             // hht, bossak
  double rho_inf = 0.8;            // generalized_alpha: spectral radius at infinite frequency
  double tolerance = 1e-8;         // relative residual of linear solves
  std::int64_t rest_rounds = 300;  // in which what flows on the way to rest must halve
  bool yields() const;             // whether any layer or block that is there does
  bool layers_have_zones() const;
  bool of_tetrahedra() const { return !mesh.empty() || !sections.empty(); }
  // Of an embankment at x, with its height; sections must be ascending and at least one.
  CrossSection section_at(double x) const;
  double narrowest_crest(double from, double to) const;  // m, half of its width, between two x
  std::int64_t zones_over_depth() const;
  // Borders of zones along an axis (0: x, 1: y of a model in space, 2: z), m, ascending. Not for a
  // mesh from a file.
  std::vector<double> edges(int axis) const;
  void declare(input::Section& s);

 private:
  void declare_mesh(input::Section& s);
  void declare_sides(input::Section& s);
  void declare_grading(input::Section& s);
  void declare_shape(input::Section& s);
  void declare_steps(input::Section& s);
  void judge_embankment(input::Section& s) const;
};

// Pa/m of the springs below a quiet base under this solid, `depth` m below the top.
// Chosen: G / depth, of the springs of a viscous-spring boundary (Liu, Du, Du, Wang, Wu 2006,
// doi:10.1007/s11803-006-0585-2: alpha G / R with R from the source to the border; alpha_N 0.8 to
// 1.2, alpha_T 0.35 to 0.65 in a plane, 1 to 2 and 0.5 to 1 in space). One number for all
// directions, since loads of a track act downwards.
double base_spring(const GroundParameters& parameters, const Elastic& solid, double depth);

// What tetrahedra are as a ground. Reads and checks a mesh file: throws InputError with everything
// that is wrong with it, and if its borders leave it a rigid motion at rest. Local.
struct MeshReport {
  Vec3 low, high;                                   // m, of all nodes
  Vec3 top_low, top_high;                           // m, of the top
  double volume = 0;                                // m^3
  std::vector<std::array<Vec3, 3>> top_faces = {};  // m, corners
  std::vector<std::string> warnings = {};
};
MeshReport look_at_mesh(const GroundParameters& parameters);

struct GroundTotals {
  std::int64_t elements = 0, nodes = 0, unknowns = 0, steps = 0;
  double iterations_mean = 0, seconds = 0;  // linear solver; wall time in steps on this rank
  double kinetic = 0, elastic = 0;          // J over all ranks
  bool springs = false;                     // whether any are below a quiet base
  double plastic = 0;                       // J lost by yielding, over all ranks
  // Newton's in implicit steps of a ground that yields: mean and most in a step, and what the last
  // step left of its forces from round to round.
  double rounds_mean = 0, rounds_most = 0;
  std::int64_t lagging_steps = 0;  // of those, whose enhanced strains lag
  std::vector<double> rounds_left = {};
};

class Ground {
 public:
  // plane: zones_y = 1, y spans +-thickness/2, and the two faces move together.
  Ground(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
         double thickness);
  ~Ground();
  Ground(Ground&&) noexcept;

  // Largest allowed step (s; explicit: safety included, infinite if implicit) and what limits it.
  double stable_step(std::string* limit = nullptr) const;

  // The top face, in the same numbering on all ranks; this rank moves the nodes it owns.
  Surface& top();
  const std::vector<int>& top_owner() const;

  // Static equilibrium under self weight and `top_force` (N per top node; only own nodes are read).
  // Base and side reactions become loads, so that quiet boundaries neither creep nor jump.
  // The shape in this state is the reference: displacement counts from it, top() does not jump.
  // Layers that yield take rounds, after each of which `go_on` is asked with their number and the
  // share of all forces that still flows, on all ranks, which must answer alike. False if it said
  // no: the ground then is of no use but to begin again. Throws RunError if there seems to be none.
  using GoOn = std::function<bool(int rounds, double flows)>;
  bool settle(std::span<const Vec3> top_force, const GoOn& go_on = {});
  // After `settle`, for a load that is another one at once: the acceleration it begins with.
  void begin_under(std::span<const Vec3> top_force);
  // Sets up what `settle` and steps of dt need of PETSc, and solves nothing. InputError if it does
  // not take its options. Collective.
  void try_solvers(double dt);
  // One window under `top_force`: explicit steps no longer than stable_step(), or one implicit
  // step. Afterwards top() holds position at the start and motion over the window. Explicit steps
  // are of second order, with damping by stiffness, which acts half a step late, of first.
  void advance(double dt, std::span<const Vec3> top_force);
  // The same for one step in two halves, for a load that depends on where the top goes. Explicit:
  // `begin_step` moves the nodes by dt under the load they have, `end_step` gives them the load of
  // their new place (as above) and completes their velocities; dt is at most stable_step().
  // Implicit: `begin_step` takes the step under the load `expected` at its end, `end_step` takes it
  // anew under another one, from there; not of a ground that yields.
  void begin_step(double dt, std::span<const Vec3> expected = {});
  void end_step(std::span<const Vec3> top_force);
  // Of an elastic ground in implicit steps of dt: what `top_force` at the end of one adds to the
  // displacement there, m, of the own top nodes. Changes nothing. Collective.
  std::vector<Vec3> give_way(double dt, std::span<const Vec3> top_force);
  bool is_implicit() const;
  std::string trouble() const;  // of this rank (divergence, not a number), or empty

  // For output: of the own top nodes, in the order of own_top(): displacement from the reference,
  // velocity, acceleration and vertical stress (tension positive, of the load since `settle`).
  std::vector<std::int32_t> own_top() const;
  struct TopState {
    Vec3 displacement, velocity, acceleration;
    double sigma_z;
  };
  TopState top_state(std::int32_t node) const;
  // Of an own top node: between the halves of an explicit step displacement at its end, velocity
  // amid it and acceleration at its begin; of an implicit one all at its end, as expected.
  struct TopMotion {
    Vec3 displacement, velocity, acceleration;  // m, m/s, m/s^2
  };
  TopMotion top_motion(std::int32_t node) const;
  // kg, lumped; shared evenly by the nodes of the surface that move as one, which are the faces of
  // a plane model and the ends of a periodic one.
  double top_mass(std::int32_t node) const;
  // Own elements with displacement, velocity, stress since settling and at rest; of both together
  // principal stresses and largest shear; plastic strain if solids yield; extremes if begun.
  io::Grid fields() const;
  // Extremes of each element's stress over the instants taken, from the last begin on (or the first
  // one taken) to the end; they go through checkpoints. Local.
  void begin_extremes();
  void take_extremes();
  void end_extremes();
  GroundTotals totals() const;  // collective
  double seconds() const;       // wall time in steps on this rank
  std::size_t memory() const;   // bytes on this rank

  void save(io::File& file, const std::string& group) const;
  void load(const io::File& file, const std::string& group);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::fem
