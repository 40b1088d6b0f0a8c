// Particles in motion and contact, distributed over ranks. Results are bitwise identical for any
// number of ranks: every contact is computed on each rank that owns one of its two particles, from
// identical data, and each particle adds its forces in the order of the partners' ids.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/timers.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/bond.hpp"
#include "trackbed/dem/breakage.hpp"
#include "trackbed/dem/law.hpp"
#include "trackbed/geom/convex.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::dem {

// Pieces may have any number of corners; without a radius they are refused with InputError.
using geom::Piece;
using geom::Template;

struct NewParticle {
  Id id = 0;         // unique; sums are in this order, so number neighbours closely
  int shape = 0;     // index of its Template
  int material = 0;  // index into Physics::materials
  double scale = 1;
  Vec3 position = Vec3::Zero();  // m, centre of mass
  Quat attitude = Quat::Identity();
  Vec3 velocity = Vec3::Zero();  // m/s
  Vec3 spin = Vec3::Zero();      // rad/s, in space axes
  bool held = false;             // keeps velocity and spin whatever the forces
};

struct Domain {
  Dimension dimension = Dimension::space;
  double thickness = 1;  // m, plane models: mass = density * area * thickness
  std::array<bool, 3> periodic{false, false, false};
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m; particles beyond a non-periodic side are lost
};

// Depth of a corner behind a surface up to which it is in contact with it, over the radius of the
// bounding sphere of its piece. Balls are in contact up to a depth of one radius.
inline constexpr double largest_corner_depth = 0.5;

struct Parameters {
  double skin = 0;          // m, reach of neighbour lists beyond contact; 0: automatic
  double rebalance = 1.15;  // work of the busiest rank over the mean; above: repartition; 0: never
  double safety = 0.2;      // sub-step over sqrt(m/k) of the stiffest contact, lightest particle
  double largest_overlap = 0.2;  // of the smaller radius; beyond it the run stops
  double gravity = trackbed::gravity;
  bool energy_balance = false;  // particles keep an EnergyAccount
  void declare(input::Section& s);
};

// Data of an own particle of a rank. Positions are unwrapped across periodic sides.
struct ParticleView {
  Id id;
  int shape, material;
  double scale, mass;
  double volume;                                 // m^3
  double size;                                   // m, smallest opening that it passes
  double radius;                                 // m, of the ball around its centre of mass
  Vec3 position, velocity, spin, force, torque;  // force without gravity
  Quat attitude;
  Vec3 angular_momentum;  // kg m^2/s, about the centre of mass, in space axes
  bool held;
  bool fragment;  // it broke off another particle
  // m/s^2, of the centre of mass, without damping by the surroundings; a particle that is held does
  // not accelerate, whatever its forces.
  Vec3 acceleration(double gravity) const {
    return held ? Vec3(Vec3::Zero()) : Vec3(force / mass - Vec3(0, 0, gravity));
  }
};

// A piece in space, for pictures. Its corners lie on the rounded surface; a ball or a segment has
// no faces, and in a plane the piece is one face.
struct PieceOutline {
  Vec3 centre;                          // m, of the ball around the piece
  double radius;                        // m, of this ball
  std::vector<Vec3> corners;            // m
  std::vector<std::vector<int>> faces;  // loops of corners, counter-clockwise seen from outside
};

// One pair in contact, reported by the rank that counts it (each contact once over all ranks).
struct ContactView {
  Id first, second;  // second: -1 - surface index for a surface
  Vec3 from, to;     // m, centres of the two pieces (surface: piece centre, contact point)
  Vec3 force;        // N, on the first, of springs only
  double overlap;    // m
  Vec3 first_centre, second_centre;  // m, of mass (surface: contact point), the image that touches
  Vec3 normal;                       // unit length, from the first to the second
  Vec3 point;                        // m, of contact, beside the first
};

// Energy up to now, J: dissipated at contacts by friction (sliding, torsion, rolling, and springs
// of Hertz contacts whose stiffness changes) and by dashpots (those of bonds included), and by
// local damping; supplied by surfaces that move. Kinetic, potential and elastic energy less what
// was supplied, plus what was dissipated, is constant up to errors of the time step. Not included:
// particles that are added, removed, stopped, held, grow or break, surfaces that are taken away or
// rotate, and changes of stiffness.
struct EnergyAccount {
  double friction = 0, contact_damping = 0, local_damping = 0, supplied = 0;

  EnergyAccount& operator+=(const EnergyAccount& o) {
    friction += o.friction, contact_damping += o.contact_damping;
    local_damping += o.local_damping, supplied += o.supplied;
    return *this;
  }
};

// Sums over all ranks' particles and contacts, each counted once; bitwise identical for any number
// of ranks.
struct Energies {
  double kinetic = 0, potential = 0, elastic = 0;  // J
  std::optional<EnergyAccount> account;            // none without Parameters::energy_balance
};

struct Totals : Energies {
  std::int64_t particles = 0, pieces = 0, contacts = 0;  // contacts: of pieces, and with surfaces
  double mass = 0;                                       // kg
  double largest_overlap = 0;                            // m
  double unbalanced = 0;                                 // mean |net force| over mean contact force
  Vec3 momentum = Vec3::Zero(), surface_force = Vec3::Zero();
};

// Bytes. Contacts: neighbour lists, kept features, histories.
struct Memory {
  std::size_t particles = 0, contacts = 0;
  std::size_t total() const { return particles + contacts; }
};

// Action of the contacts with surfaces in the last `advance`, computed from the particles: sums
// over the sub-steps, all ranks. The coupler compares it with the loads on the nodes of the
// surfaces.
struct SurfaceAction {
  Vec3 force = Vec3::Zero();   // N, sum over sub-steps of the force on the surface
  Vec3 moment = Vec3::Zero();  // Nm about the origin
  double work = 0;             // J, force times surface motion
};

// Work of the busiest rank over the mean, counted, not timed.
struct Balance {
  std::int64_t rebalances = 0;  // of this run
  double before = 1;            // at the last of them
};

// A particle that moves farther in a sub-step than contacts can detect (leap.cpp).
struct FastParticle {
  Id id;
  double travel, radius;  // m; the smallest radius of its pieces
};

// Work and messages of a sub-step if the particles were distributed over some number of ranks: of
// the rank that has most, and the mean. Work is counted as for the load balance, ns on one core.
struct Decomposition {
  double work_most = 0, work_mean = 0;              // ns, of a rank, ghosts included
  double particles_most = 0, particles_mean = 0;    // own
  double ghosts_most = 0, ghosts_mean = 0;          // received in each sub-step
  double neighbours_most = 0, neighbours_mean = 0;  // ranks that send them
  double bytes_most = 0, bytes_mean = 0;            // received in each sub-step
};

// How the particles of a checkpoint are repeated along x to fill a domain.
struct Tiling {
  std::int64_t copies = 1;
  double begin = 0, length = 1;              // m, of the cell: its lower side in x, its period
  std::vector<int> materials;                // number in this run of each material there
  std::map<std::string, std::string> names;  // of surfaces that have another name in this run
};

class Particles {
 public:
  Particles(const par::Comm& comm, const Physics& physics, const Parameters& parameters,
            const Domain& domain);
  ~Particles();
  Particles(Particles&&) noexcept;

  int add_template(const Template& shape);
  // Each rank passes the particles that it made; any split. Collective. Particles are distributed
  // by position.
  void add(std::span<const NewParticle> mine);
  // Copies the particles of a checkpoint whose model was periodic in x, with their histories,
  // motion and forces, as often as is needed to fill the domain, which must be empty. Copy k of the
  // i-th of n gets the id k n + i. In a domain that is not periodic in x, contacts beyond its ends
  // are left out. Collective.
  void tile(const io::File& file, const std::string& group, const Tiling& tiling);
  // Removes own particles for which `selected` is true (with their contacts). Collective.
  std::int64_t remove(const std::function<bool(const ParticleView&)>& selected);
  // New even partition of the domain over ranks, by the counted work or by these weights of own
  // particles (>= 0, any unit); changes no results. Collective.
  void repartition(const std::function<double(const ParticleView&)>& weight = {});
  // The same if the work is so uneven that it pays; returns whether it was done: `reaches` must
  // then be called again. Collective.
  bool rebalance();
  // New lists, where they are due: contacts and bonds are known only with lists. Collective.
  void make_lists();
  double imbalance() const;  // work of the busiest rank over the mean, now; collective
  Balance balance() const;
  // A partition of the present particles into `parts`, as on as many ranks. Only on one rank, which
  // must have lists.
  Decomposition decomposition(int parts) const;

  // Surfaces that act on the particles from now on, on every rank in the same order; they must
  // outlive their use. The contact history with a surface is kept as long as a surface of this name
  // is set.
  void set_surfaces(std::vector<Surface*> surfaces);
  // Whether stones of this rank may touch something in the box before the next repartition.
  bool reaches(const Vec3& low, const Vec3& high) const;

  // Largest allowed sub-step (safety included), s, and what limits it, in words. Collective.
  double stable_step(std::string* limit = nullptr) const;
  // The fastest own particle, if it moves farther than its smallest radius in a sub-step of dt s
  // and there is something in its path.
  std::optional<FastParticle> fast_particle(double dt) const;
  // Advances by `steps` sub-steps of length dt_window/steps while the surfaces move linearly; adds
  // to their load.
  void advance(double dt_window, int steps);
  // Problem of this rank since the last call (lost particle, not a number, overlap), or empty.
  std::string trouble();
  // Problem of the first own particle whose position or attitude is not a number, or empty. Local.
  std::string not_a_number() const;
  void set_local_damping(double alpha);  // overrides the materials' value; < 0: restores it
  void set_friction(double mu);          // overrides that of all contacts; < 0: restores it
  void scale_friction(double factor);    // overrides it by this times that of the contact laws
  // Contacts have this fraction, above 0, of the stiffness of their laws; bonds keep theirs.
  void set_stiffness(double fraction);
  void stop();  // all velocities to zero (end of a packing stage), except those of held particles
  // Particles with this id and higher ones, which are still to be added, have this fraction of
  // their size, in (0, 1], and all of their mass; all of these then grow to a larger one. Local, to
  // be called identically on all ranks. At most one batch grows at a time.
  void grow_from(Id first, double fraction);
  void grow_to(double fraction);
  double grown() const;  // that fraction

  // How corners break; once, before anything else. Only in space, for clumps of balls.
  void set_breakage(const BreakageParameters& parameters);
  // Whether they break from now on. Pebbles that are overloaded in a window break off at the begin
  // of the next one. Collective.
  void let_break(bool active);
  std::int64_t weak_pebbles() const;         // that can break off, of all ranks; -1: none may now
  const std::vector<Break>& breaks() const;  // those that this rank handled, in the order of time
  BreakTotals broken() const;

  // What kinds of bonds there are; once, before anything else.
  void set_bonds(std::vector<BondParameters> parameters);
  // Makes bonds of this kind between all pairs of stones that fulfil its conditions now and have
  // none. Returns their number. Collective.
  std::int64_t bond(std::size_t kind);
  void bonds(const std::function<void(const BondView&)>& visit) const;  // each once over ranks
  const std::vector<BondBreak>& bond_breaks() const;  // of this rank, in the order of time
  std::int64_t bonds_of(std::size_t kind) const;      // whole ones; collective
  BondTotals bonded() const;                          // collective

  std::size_t size() const;  // own particles
  bool any_corners() const;  // whether any template has a piece that is no ball
  ParticleView operator[](std::size_t i) const;
  // Balls around the pieces of own particle i, in space; for pebbles the pieces themselves.
  void pieces(std::size_t i,
              const std::function<void(const Vec3& centre, double radius)>& visit) const;
  // Balls at the corners of the pieces of own particle i, in space: a piece is the hull of its own.
  void corners(std::size_t i,
               const std::function<void(const Vec3& centre, double rounding)>& visit) const;
  void outlines(std::size_t i, const std::function<void(const PieceOutline&)>& visit) const;
  // Points spread evenly through own particle i, in space, `points_of_particle` of them: each
  // represents the same fraction of its volume.
  void points(std::size_t i, const std::function<void(const Vec3&)>& visit) const;
  static constexpr int points_of_particle = 512;
  void contacts(
      const std::function<void(const ContactView&)>& visit) const;  // each once over ranks
  Totals totals() const;                                            // collective
  Energies energies() const;  // those of `totals`, in half the time; collective
  // Largest eigenvalue of M^-1 (dt^2 K + 2 dt C) of the contacts, as computed last, over 4: above 1
  // their forces alternate from sub-step to sub-step of dt (s) and grow (contact_step.cpp).
  // Collective; needs lists.
  double alternation(double dt) const;
  // The longest sub-step up to dt, s, at which they do not. Collective; needs lists.
  double stable_step(double dt) const;
  // Of all particles, in contact: each pair counts twice, each surface once. Collective.
  std::int64_t neighbours() const;
  // A node of a surface has had a load of this many N, summed over a window: the range of the sums
  // is set to eight times as much. To be called between windows, identically on all ranks.
  void expect_load(double newtons);
  const SurfaceAction& surface_action() const;  // collective result of the last advance
  std::uint64_t state_hash() const;             // collective; independent of the rank count
  Memory memory() const;                        // of this rank
  std::int64_t steps() const;                   // sub-steps up to now
  std::int64_t rebuilds() const;
  // Pairs of stones with overlapping cores, counted once for each sub-step, of this run.
  // Collective.
  std::int64_t core_overlaps() const;
  const Domain& domain() const;
  void time_with(Timers& timers);  // for the parts of Phase::dem

  void save(io::File& file, const std::string& group) const;  // collective
  void load(const io::File& file, const std::string& group);  // any rank count; collective

 private:
  struct Impl;
  struct ContactLoop;
  class AlternatingMotion;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::dem
