// Private part of Particles: the data of a rank and the operations of a sub-step.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "dem/bond/bonding.hpp"
#include "dem/contact/stones.hpp"
#include "dem/lanes/rows.hpp"
#include "dem/law/laws.hpp"
#include "dem/particles/breaking.hpp"
#include "dem/search/grid.hpp"
#include "dem/search/near_pairs.hpp"
#include "dem/search/pairs.hpp"
#include "dem/shape/mesh.hpp"
#include "dem/state/state.hpp"
#include "trackbed/core/exact_sum.hpp"
#include "trackbed/par/halo.hpp"

namespace trackbed::dem {

class Kick;  // kick.hpp

// The sub-step `number` (from 1) of the `count` of a window; fraction = number / count of the
// window has passed at its end.
struct SubStep {
  double dt;  // s
  double fraction;
  int number, count;
};

// Data for the rolling resistance of a piece on a patch: its contacts, their weights, and their
// resultant.
struct PatchLoad {
  std::span<const MeshContact> contacts;
  std::span<const double> weights;
  double k_n;        // N/m
  double f_n, next;  // N, along the normal: now and least value in the next step
  double softening;  // of springs since the step before
};

// The rank's particles with all derived data. A checkpoint holds the state, the templates,
// histories, names of surfaces, counts, damping and quantum; the rest is derived again.
struct Particles::Impl {
  Impl(const par::Comm& comm, const Physics& physics, const Parameters& parameters,
       const Domain& domain);

  void substep(const SubStep& step);            // step.cpp
  bool lists_are_old() const;                   // collective
  bool crossed_a_border() const;                // by an own particle since the last rebuild
  double surface_motion_since_rebuild() const;  // m, at the end of this window
  // Begin a sub-step with one or two half kicks (kick.hpp).
  void kick_and_drift(double dt, int halves);
  void kick_and_drift_spheres(double dt, int halves);
  void drift_and_rotate(double dt);
  double motion_since_rebuild(std::size_t b) const;  // m, of a surface point
  void kick(double dt, int halves);
  double local_damping_of(std::size_t b) const;
  void account_for_local_damping(const Kick& kick, int halves);
  Four spin_from(std::size_t b, Four l) const;  // always by this formula
  void update_spin(std::size_t b);
  void update_accounts();
  // pair_contacts.cpp, surface_contacts.cpp
  Scene scene() const { return {state, shapes, grid, laws, pieces, skin, accounts()}; }
  // Whether what contacts dissipate is of use.
  bool accounts() const {
    return parameters.energy_balance || (breaking.active && breaking.parameters.wears());
  }
  // Forces and torques on own particles, at the present poses; histories advance by one sub-step.
  void compute_pair_forces(double dt);
  bool near_pairs_are_due(double dt);  // they may be too few after this sub-step
  void gather_near_pairs(double dt);
  void find_near_pieces();
  void place_pieces(bool all);
  // Calls visit(piece, other, d) for all pairs in the list, d from centre to centre, m.
  template <class Visit>
  void visit_pairs(Visit&& visit) const {
    for (const Row& row : pairs.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e) {
        const Entry& entry = pairs.entries[e];
        const Vec3 from = pieces.x[static_cast<std::size_t>(row.piece)].vec3();
        const Vec3 to = pieces.x[static_cast<std::size_t>(entry.piece)].vec3();
        visit(row.piece, entry.piece, Vec3(to - from + pairs.shifts[entry.shift].vec3()));
      }
  }
  // Calls visit(piece, entry of the list, xi, roll) for the pairs of balls in contact, in the order
  // of the list, which does not have the histories of near pairs (`store_near_pairs`).
  template <class Visit>
  void visit_touching(Visit&& visit) const {
    if (near_valid) return near.visit_touching(visit);
    for (const Row& row : pairs.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e)
        if (pairs.entries[e].touching)
          visit(row.piece, e, pairs.xi[e], pairs.roll.empty() ? Vec4{} : pairs.roll[e]);
  }
  double speed(std::size_t b) const;
  void mark_slow_particles(double dt);
  double fastest_slow() const;
  void store_near_pairs();
  void compute_surface_forces(const SubStep& step);
  double touch_with_ball(Approach& a, const SubStep& step);     // largest overlap over radius
  double touch_with_corners(Approach& a, const SubStep& step);  // over rounding
  void apply_ball_contact(Approach& a, const MeshContact& c, const SubStep& step);
  double apply_patch_contact(Approach& a, std::span<const MeshContact> contacts, double rounding,
                             const SubStep& step);
  // measure.cpp: of all ranks; collective.
  EnergyAccount total_of(std::span<const Vec4> accounts) const;
  std::optional<EnergyAccount> energy_account() const;  // of all particles up to now; collective
  struct PatchMotion;                                   // surface_contacts.cpp
  void load_patch(const Approach& a, std::span<const MeshContact> contacts,
                  const PatchMotion& patch, const Wrench& w, const StoneForce<double>& f,
                  const SubStep& step);
  StoneView stone_view(const Approach& a, double fraction) const;
  void add_to_surface(const Approach& a, const MeshContact& c, const Vec3& force,
                      const Vec3& motion, const SubStep& step);
  void add_rolling_resistance(const Approach& a, Approach::Patch& patch, const PatchLoad& load,
                              const SubStep& step);
  void account(std::size_t b, const Dissipation<double>& spent);
  void add_to_node(Surface& surface, int triangle, std::size_t k, const Vec3& force,
                   const SubStep& step);
  void update_surface_paths();  // path lengths, at the begin of a window
  // leap.cpp; `surface_travel`: m, of the fastest surface in dt.
  std::optional<FastParticle> fast_particle(double dt, double surface_travel) const;
  void check_tunnelling(const SubStep& step);
  // rebuild.cpp: new owners, ghosts and lists, from the state alone.
  // `rebuild`, `migrate` and `find_ghosts` are collective, `update_ghosts` among neighbours.
  void rebuild();
  void migrate(std::vector<History>& history);
  void find_ghosts();
  std::size_t bytes_of_ghost() const;  // sent to it in each sub-step
  void update_ghosts();
  void sort_own();
  void derive(std::size_t begin);  // masses, inertias, radii of particles from `begin` on
  void derive_one(std::size_t b);
  void derive_size(std::size_t b);  // quantities that depend on mass and size
  void grow_to(double fraction);    // grow.cpp
  // breakage.cpp, break_off.cpp, fragment_growth.cpp, breakage_file.cpp
  template <class Visit>
  void visit_weak(std::size_t b, Visit&& visit) const;
  void find_strengths();  // of the pebbles in the lists
  // A contact of the piece: its reduced radius and overlap, m.
  void watch(std::size_t piece, const Law& law, double radius, double overlap);
  void watch_near_pairs();
  void break_off();  // what was overloaded; collective
  double break_off(const Crack& crack, double depth, Changed& stone);
  void check_bound() const;
  std::optional<std::size_t> own_number(Id id) const;
  std::optional<std::size_t> piece_of(std::int64_t shape, std::int64_t pebble) const;
  std::vector<Crack> gather_cracks();
  void forget_cracks(const std::vector<Id>& gone);  // ascending
  const Loss& loss_of(std::int64_t shape, std::size_t piece);
  double divide(std::size_t b, const Loss& loss, const Birth& birth, Id fragment);
  void add_fragment(std::size_t b, Id id, double scale, double part);
  // overload.cpp, cut_off.cpp
  bool may_split(std::size_t b) const;
  std::vector<std::size_t> suspects(const ContactLoop& contacts) const;
  std::optional<Cut> cut_of(std::size_t b, const std::vector<ContactLoad>& loads) const;
  Cut cut_of_stone(std::size_t b) const;
  void find_cuts(int steps_of_window);  // at its end
  void find_overloads();
  void find_worn();
  bool may_wear(std::size_t b) const;
  void add_friction_work();
  std::vector<Cut> gather_cuts();  // collective
  double cut_off(const Cut& cut, std::unordered_map<Id, Changed>& stones);
  void record(const Cut& cut, const Vec3& place, double lost,
              std::initializer_list<std::pair<Id, double>> parts);
  double divide(std::size_t b, const NewPart& rest, const NewPart* piece, bool split);
  void find_growing();  // in new lists; collective
  double space_of(const GrowingFragment& fragment, double wanted) const;
  std::vector<double> depths_of(const std::vector<Crack>& cracks) const;
  void grow_fragments(int steps_of_window);  // at its begin; collective
  void set_part(std::size_t b, double part);
  void load_shapes(const io::File& file, const std::string& group);
  void save_breakage(io::File& file, const std::string& group) const;
  void load_breakage(const io::File& file, const std::string& group);
  // bonds.cpp, bonds_file.cpp
  void compute_bond_forces(const SubStep& step);
  void drop_broken_bonds();
  void find_bonds(std::size_t kind, double stretch, std::vector<Bond>& made) const;
  double longest_stretch() const;
  void migrate_bonds(const std::unordered_map<Id, std::size_t>& goes_to);  // collective
  void sort_bonds();
  void place_bonds();
  BondResponse respond_to(std::size_t n) const;
  const BondParameters& parameters_of(const Bond& bond) const {
    return bonding.parameters[static_cast<std::size_t>(bond.kind)];
  }
  BondedBody bonded_body(std::size_t b, const Vec3& shift) const;
  Vec3 image_of(std::size_t i, std::size_t j) const;
  double equal_radius(std::size_t b) const;
  bool within_box(const BondParameters& p, Vec3 point) const;
  double stable_step_of_bonds() const;
  void save_bonds(io::File& file, const std::string& group) const;
  void load_bonds(const io::File& file, const std::string& group);
  // Whether attitudes are followed: those of balls matter to bonds alone.
  bool turns() const { return !shapes.only_spheres() || bonding.any; }
  std::string not_a_number(std::size_t b) const;  // problem of an own particle, or empty
  void choose_quantum();
  // N/m of the stiffest law as declared, whatever `set_stiffness` made of it, so that the range of
  // sums is the same after a restart; hertz: at the largest overlap allowed on a particle of this
  // radius (m).
  double stiffest_contact(double radius) const;
  void find_at_border();
  void store_reference();
  // balance.cpp: sizes of cells and their owners; collective.
  void choose_grid(const std::vector<double>& work);  // of own particles
  double default_skin() const;
  std::vector<double> level_bounds() const;  // m
  std::vector<double> work() const;          // of own particles, counted, ns per sub-step; local
  double load() const;                       // the same of this rank, including ghosts; local
  std::vector<double> by_cell(const std::vector<double>& work) const;
  double upkeep(std::size_t b) const;
  double ghost_upkeep(std::size_t b) const;
  std::vector<int> other_parts(std::size_t b, const Grid& partitioned) const;
  template <class Visit>
  void visit_work(Visit&& visit) const;

  bool has_corners(std::int32_t piece) const {
    const auto p = static_cast<std::size_t>(piece);
    return shapes.any_stones() && shapes.core(pieces.core[p]).corners.size() > 1;
  }
  double mass(std::size_t b) const { return state.v[b].w; }
  // Of a particle of full size: grid and levels are made for that.
  double radius(std::size_t b) const { return shapes.bound(state.shape[b]) * state.scale[b]; }
  // For messages about overlaps; empty if contacts have the stiffness of their laws.
  std::string softness() const;
  // The first problem of a window is the cause, later ones are mostly its effects. Ranks agree on
  // it at the end of the window.
  void report(std::string problem) {
    if (trouble.empty()) trouble = std::move(problem);
  }
  int name_number(const std::string& name);
  void check_laws() const;  // throws InputError; collective
  std::vector<History> history() {
    store_near_pairs(), stone_contacts.store(stones);
    return collect_history(state, pieces, pairs, stones, approaches, surface_names);
  }
  void forget_contacts() {
    approaches.clear(), pairs.clear(), stones.clear(), bonding.places.clear();
    near.clear(), near_valid = false;
    stone_contacts.reset(scene(), stones);
  }
  par::Comm comm;
  const Physics declared;  // of the deck
  Physics physics;         // at present: with the stiffness of `set_stiffness`
  double stiffness = 1;    // of `physics` over `declared`
  Parameters parameters;
  Domain domain;
  LawTable laws;
  Shapes shapes;
  State state;

  Grid grid;
  double skin = 0;              // m
  double bound = 0;             // m, largest bounding radius over all ranks
  std::int64_t population = 0;  // of all ranks
  bool ready = false;           // lists match the state

  Balance balance;
  std::vector<std::vector<Vec3>> points_of_shape;  // m at unit scale; see Particles::points

  par::Halo halo;
  Pieces pieces;
  // Lists of this rank's pieces, ghosts included; made by `rebuild`, valid while `ready`.
  PairList pairs;
  NearPairs near;
  bool near_valid = false;                // blocks match the list and the sizes of particles
  double near_path = 0;                   // m, longest of a slow particle since they were gathered
  std::vector<std::int32_t> near_pieces;  // of near pairs and near surfaces, ascending
  StoneList stones;
  StoneContacts stone_contacts;
  std::vector<Approach> approaches;
  // Own particles that may cross a periodic side before the next rebuild and touch a surface: which
  // of its images is in contact depends on its position, not on when lists were made.
  struct AtBorder {
    std::size_t body;
    Cell wrap;
  };
  std::vector<AtBorder> at_border;
  std::vector<Vec4> reference_x, reference_q;  // own poses at the last rebuild
  double reference_grown = 1;                  // fraction of their size then
  double largest_motion = 0;  // m, of a surface point of an own particle since then
  double largest_speed = 0;   // m/s, of a slow own particle in this sub-step

  // Not owned.
  std::vector<Surface*> surfaces;
  std::vector<int> surface_names;
  std::vector<std::string> names;  // of all surfaces up to now; history refers to their numbers
  std::vector<Mesh> meshes;
  double load_quantum = 0;                           // N; only grows; the same after a restart
  std::vector<std::vector<Vec3>> surface_reference;  // m, at the end of the rebuild's window
  double surface_motion = 0;                         // m, largest of a node since then
  // m, upper bound of the path of every node of a surface up to this window, and of its travel in
  // it.
  std::vector<double> surface_path, surface_travel;
  std::vector<std::vector<Vec3>> surface_last;  // m, nodes at the end of this window
  std::vector<History> waiting;  // history of a loaded checkpoint until the lists are built

  Breaking breaking;
  Bonding bonding;
  // Of all particles; below 0: each material's own.
  double local_damping = -1;
  SurfaceAction action;
  EnergyAccount removed;  // of particles that were removed; the same on all ranks
  std::string trouble;
  std::int64_t steps = 0, rebuilds = 0;
  double elapsed = 0;  // s, simulated since the particles exist
  // Not owned; without them times are not recorded.
  Timers own_timers;
  Timers* timers = &own_timers;
  Timers::Scope scope(Phase phase) { return timers->scope(phase); }
};

}  // namespace trackbed::dem
