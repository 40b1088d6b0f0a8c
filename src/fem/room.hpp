// Inside of Ground: mesh, operators and the state, in deviation from the state of rest.
//
// All motion counts from the last `settle`: u = 0 is the ground at rest under its weight and the
// settled load F_0, held by its reactions. Since the solid is linear, the deviation obeys
//   M a + C v + K u = F - F_0,
// without weight, reactions or the static solution. So nothing creeps on quiet borders, nothing
// jumps, and the explicit run keeps its bits although the static solve is iterative. Solids that
// yield know the whole stress, of rest and deviation; what plastic strain since rest takes off K u
// is added to the equation, and rest is solved with the same bits on any split (rest.cpp).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "alpha_scheme.hpp"
#include "extremes.hpp"
#include "flat_top.hpp"
#include "free_field.hpp"
#include "linear_system.hpp"
#include "mesh.hpp"
#include "plastic_step.hpp"
#include "plasticity.hpp"
#include "stiffness.hpp"
#include "terms.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// One top node of the door: where it lives here. Both faces of a plane model, and both ends of a
// periodic one, live in one node.
struct TopNode {
  std::int32_t number, node;  // in the surface, local
  Vec3 place;                 // m, in the surface
};

// What goes through a checkpoint, listed once: nodal states at one time level.
struct State {
  State(int components, std::size_t nodes, bool implicit)
      : displacement(components, nodes),
        velocity(components, nodes),
        acceleration(components, nodes),
        internal(components, nodes),
        load(components, nodes),
        settled(components, nodes),
        offset(components, nodes),
        rest(components, nodes) {
    if (!implicit) return;
    one_before = two_before = Nodal(components, nodes);
  }
  Nodal displacement, velocity;  // m, m/s: deviation from rest
  Nodal acceleration;            // m/s^2 at the end of the last window; implicit steps carry it
  Nodal one_before, two_before;  // m/s^2, windows earlier, for the first guess; implicit steps only
  // N, K (u + rayleigh_stiffness v) + springs at the present time; after implicit steps that of
  // what their equation takes of begin and predicted end, which no later step reads.
  Nodal internal;
  Nodal load;     // N, F - F_0 of the last window
  Nodal settled;  // N, F_0
  Nodal offset;   // m, displacement at `settle`, added to the shape shown outside
  Nodal rest;     // m, static solution at `settle` under weight and F_0

  // Calls visit(name, unit, meaning, values) for each of them.
  using Visit = std::function<void(const char*, const char*, const char*, Nodal&)>;
  void list(const Visit& visit);
};

// Owns all of it. Order of members is order of building.
struct Ground::Room {
  Room(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
       double thickness);

  int components() const { return mesh.lattice.components(); }
  void set_load(std::span<const Vec3> top_force);  // load = top_force - settled
  void begin_under(std::span<const Vec3> top_force);
  // Second order in the step, but damping by stiffness acts half a step late: first order.
  void explicit_window(double dt);
  void begin_step(double h);
  void end_step(double h);
  void implicit_window(double dt, const Nodal& load_before);
  // The window just taken once more, its load at the end now state.load instead of `expected`.
  void correct_window(double dt, const Nodal& expected);
  // m: what state.load, and what is settled, at the end of a window adds to displacements there.
  Nodal give_way(double dt);
  bool settle(std::span<const Vec3> top_force, const Ground::GoOn& go_on);
  void try_solvers(double dt);
  // Local; of the model's state, whatever is asked: Pa since rest or at rest.
  Vec6 stress(std::size_t zone, Plasticity::Where where, Plasticity::When when) const;
  // Collective.
  void publish();          // ghosts of u current, surface motion of this window
  void show_motion();      // ghosts of what the top shows current, if it shows them
  void refresh_surface();  // positions from the state, no motion
  void add_energies(GroundTotals& totals) const;
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
  std::unique_ptr<FlatTop> flat_top;       // if the ground is from a file
  std::unique_ptr<Plasticity> plasticity;  // if a solid yields
  std::unique_ptr<FreeField> free_field;   // if a wave comes from below
  std::unique_ptr<Extremes> extremes;      // if begun, of all zones held
  double time = 0;                         // s since `settle`, for that wave
  double step_in_halves = 0;               // s, of begin_step and end_step
  Nodal expected;                          // N, of an implicit one, the load it began with
  Surface surface;
  std::vector<TopNode> own_top;
  // Of a ground from a file: local node of the top and number of a face there, ascending.
  std::vector<std::pair<std::int32_t, std::int32_t>> faces_at;
  std::vector<std::int32_t> top_nodes;  // local ones of own_top, each once, ascending
  double critical = 0;                  // s, without safety
  std::string limit, trouble;
  std::int64_t steps = 0, solves = 0, iterations = 0;
  // Newton's: rounds of all implicit steps, most of one, steps whose enhanced strains lag; what the
  // last one left round by round.
  std::int64_t newton_steps = 0, rounds = 0, most_rounds = 0, lagging_steps = 0;
  std::vector<double> left;  // residual over the forces of the step
  double seconds = 0;

 private:
  void make_surface();
  void import_surface();
  void finish_surface();
  // state.internal from what the zones see and what the base springs see.
  void internal_force(const Nodal& w, const Nodal& u);
  void yield(bool ghosts_current);  // flow under the present displacement, and its forces
  void extrapolate();
  double balance(const AlphaScheme& scheme, const Nodal& load_before);
  // A step in time. N: its rounding and what it is measured by; where its rounds have come to.
  struct NewtonStep {
    double dt;
    const AlphaScheme& scheme;
    double rounding, all = 0, left = 0, strain = 0;
    std::int64_t lost = 0;
    int rounds = 0, tried = 0;  // of this try, of those before
    bool ended = false;
  };
  void newton(double dt, const AlphaScheme& scheme, double rounding);
  bool comes_to_an_end(NewtonStep& step, PlasticStep::Follow when, int most);
  bool newton_rounds(NewtonStep& step, int most);
  static std::string no_end(const NewtonStep& step);
  double out_of_balance(double dt, const AlphaScheme& scheme, const Nodal& acceleration);
  double line_search(double dt, const AlphaScheme& scheme, const Nodal& step, double open);
  LinearSystem::Spec rest_spec() const;
  void elastic_rest(const Nodal& right);
  bool yielding_rest(const Nodal& right, const Ground::GoOn& go_on);
  enum class Part { drift, kick_and_drift, kick };
  void move(Part part, double h);
  void pull_back(double h, double at);  // internal forces once the nodes have moved
  void prepare_step(double h);
  void prepare_window(double dt, const AlphaScheme& scheme);
  void predict(double dt, const AlphaScheme& scheme);
  void check_finite();

  // Explicit: derived numbers per node, and the displacement the stiffness acts on.
  Nodal inverse_mass_, damping_rate_, implicit_factor_;  // 1/kg (0: held, ghost), 1/s, -
  Nodal blend_;  // u + rayleigh_stiffness v, if that differs
  double prepared_step_ = -1;
  std::vector<Vec3> window_start_;  // displacement of own top nodes as the window began
  // Implicit: scratch of a window, and the operator.
  Nodal mixed_, right_;
  std::unique_ptr<LinearSystem> implicit_;
  std::unique_ptr<PlasticStep> plastic_step_;  // if a solid yields
  Nodal begin_force_, end_force_, residual_;   // N: of plastic strain at begin and end; of Newton
  Nodal newton_step_, search_from_;            // m/s^2: of Newton; where a search along it begins
  Nodal stiff_;  // N/m, diagonal of K, with what damping by stiffness adds to it; held: 0
  double implicit_step_ = -1, rounding_ = 0;  // s; N, of the right side
};

}  // namespace trackbed::fem
