// The ground, distributed over ranks: layers of 8-node hexahedra, or 10-node tetrahedra that form
// an embankment of these layers or come from a mesh file.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/timers.hpp"
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

// Strength of a solid. The Mohr-Coulomb shear strength is c - sigma_n tan(phi), without hardening.
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
  std::string young_file = {};  // Young's modulus along x instead of a constant
  Strength strength = {};
  std::int64_t elements = 0;  // over its height; 0: a fraction of elements_z by thickness
  void declare(input::Section& s);
};

// What a block is in comparisons of transitions; automatic: it follows from modulus and depth.
enum class BlockRole { automatic, structure, measure };

// A region cut out of the layers: elements whose centre is inside the outline are made of its
// solid; later blocks overrule earlier ones. Used for structure, wedge and surface layer of the
// transition.
struct Block {
  std::string name;
  bool present = true;
  std::vector<double> outline;  // m, x and z of each corner in turn; z = 0 is the top
  Elastic solid;
  Strength strength = {};
  std::vector<double> y = {};             // m, from and to; empty: the whole width of the ground
  BlockRole role = BlockRole::automatic;  // has no effect on a run
  // m, x of each upright side (axis 0), or z of each level one (axis 2).
  std::vector<double> sides_across(int axis) const;
  double height() const;  // m
  void declare(input::Section& s);
};

// The outline of an embankment across the track at one place along it, symmetric about y = 0.
struct CrossSection {
  double x = 0;        // m
  double crest = 3;    // m, half of its width
  double height = 0;   // m, of the crest above the natural ground; 0: that of its layers
  double slope = 1.5;  // of its sides, horizontal to vertical
  void declare(input::Section& s);
  double foot() const { return crest + slope * height; }  // m, half of its width at the foot
};

// Material of the elements of a physical volume of a mesh file.
struct MeshSolid {
  std::string name;  // of the physical volume
  Elastic solid;
  Strength strength = {};
  void declare(input::Section& s);
};

// Boundary condition of a physical surface of a mesh file. Rollers hold along the normal; a viscous
// border has dashpots, and springs if it is a base.
enum class BorderKind { free, fixed, roller, viscous };
struct MeshBorder {
  std::string name;  // of the physical surface
  BorderKind holds = BorderKind::roller;
  void declare(input::Section& s);
};

enum class Integrator { explicit_, newmark, hht, bossak, generalized_alpha };
enum class PlaneState { stress, strain };
enum class Base { fixed, viscous };  // viscous: Lysmer & Kuhlemeyer 1969 dashpots
// Boundary conditions of the lateral sides. roller: held along the normal, that is a plane of
// symmetry; free_field: dashpots against columns that move with the wave from below only; as_sides:
// for a single side, the condition of `sides`; periodic: joined to the opposite side.
enum class Sides { free, roller, viscous, free_field, fixed, as_sides, periodic };

struct GroundParameters {
  bool present = true;
  // Gmsh file; then solids and borders are used, and the parameters of layers and blocks are not.
  std::string mesh;
  std::string mesh_top = "top";  // physical surface below the stones
  std::vector<MeshSolid> solids;
  std::vector<MeshBorder> borders;
  std::vector<double> x = {0, 10};        // m, from and to
  std::vector<double> y = {-0.65, 0.65};  // m; a plane model takes its thickness from the model
  std::int64_t elements_x = 100, elements_y = 1, elements_z = 50;
  // The width of each element over that of its neighbour towards `fine`, m; 1: equal widths.
  double ratio_x = 1, ratio_y = 1, fine_x = 0, fine_y = 0;
  std::vector<Layer> layers;
  std::vector<Block> blocks;
  std::vector<CrossSection> sections;  // of an embankment, linear between; its top is the crest
  std::int64_t embankment_layers = 0;  // of these layers, from the top down; natural ground below
  PlaneState plane = PlaneState::stress;
  Base base = Base::viscous;
  // Pa/m of springs in parallel with the dashpots of a viscous base: the ground below; 0: none;
  // below 0: chosen by `base_spring`.
  double base_stiffness = -1;
  Sides sides = Sides::roller;
  Sides side_x_low = Sides::as_sides, side_x_high = Sides::as_sides;
  Sides side_y_low = Sides::as_sides, side_y_high = Sides::as_sides;
  Sides side(int axis, bool high) const;  // normal to x (0) or y (1); as_sides is resolved
  bool periodic(int axis) const { return side(axis, false) == Sides::periodic; }
  std::string base_motion;  // file: velocity of a wave that enters through a viscous base
  double rayleigh_mass = 0, rayleigh_stiffness = 0;  // 1/s, s; of solids without own values
  Integrator integrator = Integrator::explicit_;
  double safety = 0.8;  // explicit step over the critical one
  double newmark_beta = 0.25, newmark_gamma = 0.5;
  double alpha = -0.1;      // hht, bossak
  double rho_inf = 0.8;     // generalized_alpha: spectral radius at infinite frequency
  double tolerance = 1e-8;  // relative residual of linear solves
  // Within so many iterations the out-of-balance force of a static solve must halve.
  std::int64_t static_iterations = 300;
  bool yields() const;  // whether any present layer or block has a strength
  bool layers_have_elements() const;
  bool of_tetrahedra() const { return !mesh.empty() || !sections.empty(); }
  // Cross-section of an embankment at x, with its height resolved; needs ascending sections, at
  // least one.
  CrossSection section_at(double x) const;
  double narrowest_crest(double from, double to) const;  // m, half of its width, between two x
  std::int64_t elements_over_depth() const;
  // Element borders along an axis (0: x, 1: y of a model in space, 2: z), m, ascending. Not for a
  // mesh file.
  std::vector<double> edges(int axis) const;
  void declare(input::Section& s);

 private:
  void declare_mesh(input::Section& s);
  void declare_base(input::Section& s);
  void declare_sides(input::Section& s);
  void declare_grading(input::Section& s);
  void declare_shape(input::Section& s);
  void declare_steps(input::Section& s);
  void check_embankment(input::Section& s) const;
};

// Pa/m of the springs of a viscous base below this solid, `depth` m below the top. The value chosen
// is G / depth, as for a viscous-spring boundary (Liu, Du, Du, Wang, Wu 2006,
// doi:10.1007/s11803-006-0585-2: alpha G / R with R from the source to the border; alpha_N 0.8 to
// 1.2, alpha_T 0.35 to 0.65 in a plane, 1 to 2 and 0.5 to 1 in space). One value is used for all
// directions, since the loads of a track act downwards.
double base_spring(const GroundParameters& parameters, const Elastic& solid, double depth);

// Geometry of a ground of tetrahedra. Reads and checks a mesh file: throws InputError with all its
// problems, and if its boundary conditions permit a rigid motion in static equilibrium. Local.
struct MeshReport {
  Vec3 low, high;                                   // m, of all nodes
  Vec3 top_low, top_high;                           // m, of the top
  double volume = 0;                                // m^3
  std::vector<std::array<Vec3, 3>> top_faces = {};  // m, corners
  std::vector<std::string> warnings = {};
};
MeshReport look_at_mesh(const GroundParameters& parameters);

// J, over all ranks: of the motion since static equilibrium; dissipated by yielding up to now.
struct GroundEnergies {
  double kinetic = 0, elastic = 0, plastic = 0;
  bool yields = false;  // whether any layer or block can
};

struct GroundTotals : GroundEnergies {
  std::int64_t elements = 0, nodes = 0, unknowns = 0, steps = 0;
  double iterations_mean = 0, seconds = 0;  // of the linear solver; wall time of steps on this rank
  bool springs = false;                     // whether a viscous base has springs
  // Newton iterations in implicit steps of a yielding ground: mean and maximum per step, and the
  // out-of-balance force of the last step after each iteration.
  double newton_mean = 0, newton_most = 0;
  std::int64_t lagging_steps = 0;  // implicit steps with lagged enhanced strains
  std::vector<double> newton_residuals = {};
};

// Numbers of the blocks that contain centres of elements, all of which later blocks contain, too.
// For a ground of boxes; local, in the time of a visit to each element.
std::vector<std::size_t> covered_blocks(const GroundParameters& parameters, Dimension dimension);

// A place in the ground at rest: the element that contains it and its natural coordinates there.
struct GroundPoint {
  Id element = -1;  // -1: outside of the ground
  Vec3 xi = Vec3::Zero();
};

// At such a place: motion by the element's shape functions; stress at the element's centre, Pa,
// xx yy zz xy xz yz, tension positive. The total stress is the sum of both.
struct GroundPointState {
  Vec3 displacement = Vec3::Zero(), velocity = Vec3::Zero();  // m, m/s, since static equilibrium
  Vec3 acceleration = Vec3::Zero();                           // m/s^2
  std::array<double, 6> stress{};                             // since static equilibrium
  std::array<double, 6> stress_static{};                      // in static equilibrium
};

class Ground {
 public:
  // plane: elements_y = 1, y is within +-thickness/2, and both faces have the same displacement.
  Ground(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
         double thickness);
  ~Ground();
  Ground(Ground&&) noexcept;

  // Largest allowed step (s; explicit: including the safety factor, infinite if implicit) and what
  // limits it.
  double stable_step(std::string* limit = nullptr) const;

  // The top face, in the same numbering on all ranks; this rank moves the nodes it owns.
  Surface& top();
  const std::vector<int>& top_owner() const;

  // Static equilibrium under self weight and `top_force` (N per top node; only own nodes are read).
  // Reactions at base and sides become loads, so that viscous boundaries neither creep nor jump.
  // The deformed shape is the reference: displacement is measured from it, and top() does not jump.
  // A yielding ground is solved iteratively: after each iteration `monitor` is called with the
  // number of iterations and the relative out-of-balance force, on all ranks, and must return the
  // same value on all. Returns false if `monitor` did; the state is then invalid except as a new
  // start. Throws RunError if the solve does not converge.
  using StaticMonitor = std::function<bool(int iterations, double residual)>;
  bool settle(std::span<const Vec3> top_force, const StaticMonitor& monitor = {});
  // After `settle`, for a load that differs from the settled one at once: sets the initial
  // acceleration.
  void initialise_acceleration(std::span<const Vec3> top_force);
  // Sets up the PETSc solvers of `settle` and of steps of dt without solving. Throws InputError if
  // PETSc rejects its options. Collective.
  void try_solvers(double dt);
  // One window under `top_force`: explicit steps no longer than stable_step(), or one implicit
  // step. Afterwards top() holds the position at the start and the motion over the window. Explicit
  // steps are second-order accurate; stiffness-proportional damping acts half a step late and is
  // first-order.
  void advance(double dt, std::span<const Vec3> top_force);
  // The same under a load that varies within the window. `load(t)`: load t s after its start, valid
  // until the next call; asked for the end of each step, which may be the end of the window. A load
  // that is constant in each window, like that of stones, would give velocities of the top with an
  // error of first order.
  using LoadInWindow = std::function<std::span<const Vec3>(double since_start)>;
  void advance(double dt, const LoadInWindow& load);
  // The same for one step in two halves, for a load that depends on the motion of the top.
  // Explicit: `begin_step` moves the nodes by dt under the present load, `end_step` sets the load
  // of the new position (as above) and completes the velocities; dt is at most stable_step().
  // Implicit: `begin_step` solves the step under the load `expected` at its end, `end_step` solves
  // it again under another load, with that solution as first guess; not for a yielding ground.
  void begin_step(double dt, std::span<const Vec3> expected = {});
  void end_step(std::span<const Vec3> top_force);
  // For an elastic ground in implicit steps of dt: displacement, m, of the own top nodes at the end
  // of a step due to `top_force` there. Changes no state. Collective.
  std::vector<Vec3> deflection(double dt, std::span<const Vec3> top_force);
  bool is_implicit() const;
  std::string trouble() const;  // on this rank (divergence, not a number), or empty

  // For output, of the own top nodes in the order of own_top(): displacement from the reference,
  // velocity, acceleration and vertical stress (tension positive, due to the change of load since
  // `settle`).
  std::vector<std::int32_t> own_top() const;
  struct TopState {
    Vec3 displacement, velocity, acceleration;
    double sigma_z;
  };
  TopState top_state(std::int32_t node) const;
  // Of an own top node. Between the halves of an explicit step: displacement at the end of the
  // step, velocity at mid-step and acceleration at its start; of an implicit step: all at its end,
  // under the expected load.
  struct TopMotion {
    Vec3 displacement, velocity, acceleration;  // m, m/s, m/s^2
  };
  TopMotion top_motion(std::int32_t node) const;
  // Of each place, m; y is not used in a plane. Bitwise the same on any number of ranks with an
  // explicit ground, the static stress only if the ground yields. Collective, as states_at.
  std::vector<GroundPoint> locate(std::span<const Vec3> places) const;
  std::vector<GroundPointState> states_at(std::span<const GroundPoint> points) const;
  // kg, lumped; divided evenly among the nodes of the surface with the same motion, that is the two
  // faces of a plane model and the ends of a periodic one.
  double top_mass(std::int32_t node) const;
  // Own elements with displacement, velocity, stress since settling and static stress; of their sum
  // principal stresses and largest shear stress; plastic strain if solids yield; extremes if begun.
  io::Grid fields() const;
  // Extremes of each element's stress over the instants taken, from the last `begin_extremes` (or
  // the first instant taken) to `end_extremes`; they are part of checkpoints. Local.
  void begin_extremes();
  void take_extremes();
  void end_extremes();
  GroundTotals totals() const;      // collective
  GroundEnergies energies() const;  // collective
  void time_with(Timers& timers);   // for the parts of Phase::ground
  std::size_t memory() const;       // bytes on this rank

  void save(io::File& file, const std::string& group) const;
  void load(const io::File& file, const std::string& group);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::fem
