// Private part of Ground: mesh, operators and the state, in deviation from static equilibrium.
//
// All motion is relative to the last `settle`: u = 0 is the ground in static equilibrium under its
// weight and the settled load F_0, held by its reactions. Since the solid is linear, the deviation
// obeys
//   M a + C v + K u = F - F_0,
// without weight, reactions or the static solution. So viscous boundaries do not creep, nothing
// jumps, and explicit runs are bitwise identical although the static solve is iterative. Yielding
// solids use the whole stress, static and of the deviation; the force that plastic strain since
// equilibrium takes off K u is added to the equation, and the static solve is bitwise identical on
// any number of ranks (static_equilibrium.cpp).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fem/boundary/free_field.hpp"
#include "fem/boundary/terms.hpp"
#include "fem/ground/extremes.hpp"
#include "fem/kernel/plastic_step.hpp"
#include "fem/kernel/plasticity.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/flat_top.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/solver/linear_system.hpp"
#include "fem/time/alpha_scheme.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// A node of the top surface and its node in the mesh. Both faces of a plane model, and both ends of
// a periodic one, share one node.
struct TopNode {
  std::int32_t number, node;  // in the surface, local
  Vec3 place;                 // m, in the surface
};

// State in a checkpoint, listed once: nodal values at one time level.
struct State {
  State(int components, std::size_t nodes, bool implicit)
      : displacement(components, nodes),
        velocity(components, nodes),
        acceleration(components, nodes),
        internal(components, nodes),
        load(components, nodes),
        settled(components, nodes),
        offset(components, nodes),
        static_displacement(components, nodes) {
    if (!implicit) return;
    one_before = two_before = Nodal(components, nodes);
  }
  Nodal displacement, velocity;  // m, m/s: deviation from static equilibrium
  Nodal acceleration;            // m/s^2 at the end of the last window; state of implicit steps
  Nodal one_before, two_before;  // m/s^2, windows earlier, for the first guess; implicit steps only
  // N, K (u + rayleigh_stiffness v) + springs at the present time; after implicit steps that of the
  // motion in their equation, mixed from begin and predicted end, which no later step reads.
  Nodal internal;
  Nodal load;                 // N, F - F_0 of the last window
  Nodal settled;              // N, F_0
  Nodal offset;               // m, displacement at `settle`, added to the shape of the surface
  Nodal static_displacement;  // m, static solution at `settle` under weight and F_0

  // Calls visit(name, unit, meaning, values) for each array.
  using Visit = std::function<void(const char*, const char*, const char*, Nodal&)>;
  void list(const Visit& visit);
};

// Owns all parts. The order of members is the order of construction.
struct Ground::Impl {
  Impl(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
       double thickness);

  int components() const { return mesh.lattice.components(); }
  void set_load(std::span<const Vec3> top_force);  // load = top_force - settled
  void initialise_acceleration(std::span<const Vec3> top_force);
  // Second order in the step, except for stiffness-proportional damping, which acts half a step
  // late: first order.
  void explicit_window(double dt, const LoadInWindow& load);
  void begin_step(double h);
  void end_step(double h);
  void implicit_window(double dt, const Nodal& load_before);
  // Solves the window again, with state.load instead of `expected` as the load at its end.
  void solve(const Nodal& right, double rounding);
  void correct_window(double dt, const Nodal& expected);
  // m: displacements at the end of a window due to state.load plus the settled load.
  Nodal deflection(double dt);
  bool settle(std::span<const Vec3> top_force, const Ground::StaticMonitor& monitor);
  void try_solvers(double dt);
  // Local; from the state of the model: Pa since equilibrium or static.
  Vec6 stress(std::size_t element, Plasticity::Where where, Plasticity::When when) const;
  // Collective.
  void publish();          // ghosts of u current, surface motion of this window
  void show_motion();      // makes ghosts current if the surface depends on them
  void refresh_surface();  // positions from the state, no motion
  GroundEnergies energies() const;
  Vec3 vector(const Nodal& values, std::int32_t node) const;
  Vec3 at_top(const Nodal& values, std::int32_t node) const;  // as the surface shows them
  Vec3 shown_displacement(std::int32_t node) const;
  double surface_stress(std::int32_t node) const;  // Pa, sigma_z at a top node
  double imported_surface_stress(std::int32_t node) const;
  std::int32_t node_of_top(std::int32_t number) const;  // local, of an own node of the surface

  GroundParameters parameters;
  Dimension dimension;
  Mesh mesh;
  Stiffness stiffness;
  Terms terms;
  State state;
  std::unique_ptr<FlatTop> flat_top;       // of tetrahedra
  std::unique_ptr<Plasticity> plasticity;  // if a solid yields
  std::unique_ptr<FreeField> free_field;   // if a wave enters from below
  std::unique_ptr<Extremes> extremes;      // if begun, of all elements held
  double time = 0;                         // s since `settle`, time of that wave
  double step_in_halves = 0;               // s, of begin_step and end_step
  Nodal expected;                          // N, load with which an implicit one was begun
  Surface surface;
  std::vector<TopNode> own_top;
  // Of a ground of tetrahedra: local node of the top and number of a face there, ascending.
  std::vector<std::pair<std::int32_t, std::int32_t>> faces_at;
  std::vector<std::int32_t> top_nodes;  // local ones of own_top, each once, ascending
  double critical = 0;                  // s, without safety factor
  std::string limit, trouble;
  std::int64_t steps = 0, solves = 0, iterations = 0;
  // Newton iterations of all implicit steps, maximum of one step, steps with lagged enhanced
  // strains; residuals of the last step by iteration.
  std::int64_t newton_steps = 0, newton_iterations = 0, most_newton_iterations = 0,
               lagging_steps = 0;
  std::vector<double> newton_residuals;  // relative to the forces of the step
  double seconds = 0;
  Timers own_timers;
  Timers* timers = &own_timers;

 private:
  void make_surface();
  void import_surface();
  void finish_surface();
  // state.internal from the displacements w of elements and u of base springs.
  void internal_force(const Nodal& w, const Nodal& u);
  void yield(bool ghosts_current);  // plastic strain under the present displacement, and its forces
  void extrapolate();
  double balance(const AlphaScheme& scheme, const Nodal& load_before);
  // A time step solved by Newton. N: rounding error of its forces and their size; progress of its
  // iterations.
  struct NewtonStep {
    double dt;
    const AlphaScheme& scheme;
    double rounding, scale = 0, residual = 0, enough = 0, strain = 0;
    std::int64_t unsolved = 0;
    int iterations = 0, earlier = 0;  // of this attempt, of earlier ones
    bool converged = false;
  };
  void newton(double dt, const AlphaScheme& scheme, double rounding);
  bool converges(NewtonStep& step, PlasticStep::Follow when, int most);
  bool iterate_newton(NewtonStep& step, int most);
  static std::string not_converged(const NewtonStep& step);
  double out_of_balance(double dt, const AlphaScheme& scheme, const Nodal& acceleration);
  double line_search(double dt, const AlphaScheme& scheme, const Nodal& step, double residual);
  LinearSystem::Spec static_spec() const;
  void elastic_equilibrium(const Nodal& right);
  bool yielding_equilibrium(const Nodal& right, const Ground::StaticMonitor& monitor);
  enum class Part { drift, kick_and_drift, kick };
  void move(Part part, double h);
  void compute_forces(double h, double at);  // internal forces once the nodes have moved
  void prepare_step(double h);
  void prepare_window(double dt, const AlphaScheme& scheme);
  void predict(double dt, const AlphaScheme& scheme);
  void check_finite();

  // Explicit: derived numbers per node, and the displacement the stiffness acts on.
  Nodal inverse_mass_, damping_rate_, implicit_factor_;  // 1/kg (0: fixed, ghost), 1/s, -
  Nodal blend_;  // u + rayleigh_stiffness v, if it differs from u
  double prepared_step_ = -1;
  std::vector<Vec3> window_start_;  // displacement of own top nodes at the start of the window
  // Implicit: scratch arrays of a window, and the operator.
  Nodal mixed_, right_;
  std::unique_ptr<LinearSystem> implicit_;
  std::unique_ptr<PlasticStep> plastic_step_;  // if a solid yields
  Nodal begin_force_, end_force_, residual_;   // N: of plastic strain, at begin and end; Newton's
  Nodal newton_step_, search_from_;            // m/s^2: Newton step; start of its line search
  Nodal stiff_;  // N/m, diagonal of K with damping by stiffness; fixed: 0
  double implicit_step_ = -1, rounding_ = 0;  // s; N, of the right-hand side
};

}  // namespace trackbed::fem
