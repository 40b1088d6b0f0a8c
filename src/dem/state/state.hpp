// The particles of a rank. Their quantities are listed once, in `visit_all`: migration, ghosts,
// checkpoints, sorting, adding and removing use this list.
#pragma once

#include <vector>

#include "dem/lanes/vec4.hpp"
#include "dem/shape/core.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

// Own particles first, [0, own), in the order of their ids; then ghosts. One array for each
// quantity. Vectors have four numbers, the fourth of which stores a value that is read together
// with them (radius, mass): one load reads both.
struct State {
  std::size_t own = 0;
  std::vector<Id> id;
  std::vector<std::int64_t> shape, material;
  std::vector<double> scale;
  std::vector<std::int64_t> held;  // 1: velocity and spin are prescribed
  std::vector<double> part;        // of a fragment: ratio of its size to the final one; else 0
  std::vector<Vec4> x;             // m, centre of mass, unwrapped; w: bounding radius
  std::vector<Vec4> q;             // attitude, unit quaternion
  std::vector<Vec4> v;             // m/s; w: mass
  std::vector<Vec4> l;  // kg m^2/s, angular momentum in space axes; w: 1 over the moment about y
  // The fourth numbers of f and t are what dashpots and friction dissipate at the particle's
  // contacts in this sub-step, J, if that is of use (Particles::Impl::accounts).
  std::vector<Vec4> f;         // N, from contacts, at the time of x
  std::vector<Vec4> t;         // Nm
  std::vector<Vec4> account;   // J, see EnergyAccount, since the particle exists
  std::vector<double> rubbed;  // J, friction work of which the wear is not yet taken off
  // Derived
  std::vector<Vec4> w;        // rad/s, spin in space axes at the time of v in the force loop
  std::vector<Vec4> inertia;  // kg m^2, principal moments

  // Particles with this id and higher ones grow: present fraction of their size. Their mass is
  // constant, so that the sub-step need not be that of small ones.
  Id growing = 0;
  double grown = 1;

  std::size_t size() const { return id.size(); }
  bool is_fragment(std::size_t b) const { return part[b] > 0; }
  double size_fraction(std::size_t b) const {
    if (is_fragment(b)) return part[b];
    return id[b] < growing ? 1 : grown;
  }
  double scale_now(std::size_t b) const { return scale[b] * size_fraction(b); }
};

// Data of a quantity sent to a ghost: nothing; its value when the ghost is made; its value in each
// sub-step; the last only where attitudes are used (not all particles are spheres).
enum class Ghost { nothing, once, each_step, turning };
// Stored quantities are sent to new owners and written to checkpoints; the others are derived.
enum class Storage { stored, derived };

template <int columns_, Ghost ghost_, Storage storage_ = Storage::stored>
struct Quantity {
  static constexpr int columns = columns_;  // numbers (of 8 bytes) in use, from the first
  static constexpr Ghost ghost = ghost_;
  static constexpr Storage storage = storage_;
  const char *name, *unit, *meaning;
};

// The list of all quantities: visit(quantity, array) for each.
template <class S, class Visit>
constexpr void visit_all(S& s, Visit&& visit) {
  using enum Ghost;
  visit(Quantity<1, once>{"id", "-", "number of the particle, the same on every rank"}, s.id);
  visit(Quantity<1, once>{"shape", "-", "number of the template"}, s.shape);
  visit(Quantity<1, once>{"material", "-", "number of the material"}, s.material);
  visit(Quantity<1, once>{"scale", "-", "ratio of size to that of the template"}, s.scale);
  visit(Quantity<1, once>{"held", "-", "1: keeps velocity and spin whatever the forces; else 0"},
        s.held);
  visit(Quantity<1, once>{"part", "-", "of a fragment: ratio of its size to the final one; else 0"},
        s.part);
  visit(Quantity<3, each_step>{"position", "m", "centre of mass, unwrapped across periodic sides"},
        s.x);
  visit(Quantity<4, turning>{"attitude", "-", "quaternion x y z w from principal axes to space"},
        s.q);
  visit(Quantity<3, each_step>{"velocity", "m/s", "of the centre of mass"}, s.v);
  visit(Quantity<3, nothing>{"angular_momentum", "kg m2/s",
                             "about the centre of mass, in space axes"},
        s.l);
  visit(Quantity<3, nothing>{"force", "N", "sum of contact forces at this time, without gravity"},
        s.f);
  visit(Quantity<3, nothing>{"torque", "Nm",
                             "sum of contact torques about the centre of mass at this time"},
        s.t);
  visit(Quantity<1, nothing>{"friction_work", "J",
                             "done by friction on stones that wear, whose wear is still to come"},
        s.rubbed);
  visit(Quantity<4, nothing>{"energy_account", "J",
                             "columns: dissipated by friction, by dashpots of contacts, by local "
                             "damping; supplied by surfaces; of a pair half each"},
        s.account);
  visit(Quantity<3, each_step, Storage::derived>{"spin", "rad/s", "in space axes"}, s.w);
  visit(Quantity<3, nothing, Storage::derived>{"inertia", "kg m2", "principal moments"}, s.inertia);
}

// The stored quantities. Position and velocity are sent with their fourth number in `pack`; it is
// derived again on arrival.
template <class S, class Visit>
void visit_state(S& s, Visit&& visit) {
  visit_all(s, [&](auto quantity, auto& array) {
    if constexpr (quantity.storage == Storage::stored) visit(quantity, array);
  });
}

// Selects these rows of every stored quantity, in this order; a row may occur more than once.
void pick(State& state, const std::vector<std::size_t>& rows);

// Templates flattened for the kernels. All pieces of all templates in turn; those of a template are
// in [begin, end).
class Shapes {
 public:
  // `labels`: of the pieces, their numbers in the unbroken stone; none: their own numbers.
  int add(const Template& shape, std::vector<std::int64_t> labels = {});
  // By one with as many pieces and corners, for all particles that have it.
  void replace(std::int64_t number, const Template& shape);
  std::size_t size() const { return templates_.size(); }
  const std::vector<Template>& templates() const { return templates_; }
  const Template& operator[](std::int64_t shape) const {
    return templates_[static_cast<std::size_t>(shape)];
  }
  std::size_t begin(std::int64_t shape) const { return begin_[static_cast<std::size_t>(shape)]; }
  std::size_t end(std::int64_t shape) const { return begin_[static_cast<std::size_t>(shape) + 1]; }
  // Ball around a piece: centre; w: radius; unit scale.
  const Vec4& piece(std::size_t k) const { return pieces_[k]; }
  const Core& core(std::size_t k) const { return cores_[k]; }
  std::int64_t label(std::size_t k) const { return labels_[k]; }
  const std::vector<std::int64_t>& labels() const { return labels_; }  // of all pieces in turn
  // Corners of all cores in turn, as in `Core`, and the first of each core.
  const std::vector<Vec4>& corners() const { return corners_; }
  std::uint32_t first_corner(std::size_t k) const { return first_corner_[k]; }
  double bound(std::int64_t shape) const { return bound_[static_cast<std::size_t>(shape)]; }
  // Smallest radius of a piece, of one with corners its rounding; unit scale.
  double least_radius(std::int64_t shape) const {
    return least_radius_[static_cast<std::size_t>(shape)];
  }
  bool only_spheres() const { return only_spheres_; }  // one centred piece each
  bool any_stones() const { return any_stones_; }      // a piece with several corners

 private:
  std::vector<Template> templates_;
  std::vector<std::size_t> begin_{0};
  std::vector<Vec4> pieces_;
  std::vector<Core> cores_;  // of each piece
  std::vector<std::int64_t> labels_;
  std::vector<Vec4> corners_;
  std::vector<std::uint32_t> first_corner_;
  std::vector<double> bound_, least_radius_;
  bool only_spheres_ = true, any_stones_ = false;
};

// Mass in kg of a particle of this template: area times thickness in a plane model.
double mass_of(const Template& shape, double scale, double density, const Domain& domain);

// Contact history between two pieces, or a piece and a patch of a surface, during transfer from one
// neighbour list to the next, to another rank or to a checkpoint. Only data that do not follow from
// the poses. Sorted by its two keys. Members have 8 bytes, so that there is no padding: migration
// and the state hash use the bytes. They have no initial values, so that the compiler reports an
// initialiser in which one of them is missing.
struct History {
  std::int64_t first;   // key of the piece with the lower id
  std::int64_t second;  // key of the other piece, or -1 - (surface * 2^32 + patch)
  double xi[3];         // m, tangential displacement
  double turn;          // rad, relative rotation about the normal
  double size;          // m, contact size at which xi was stretched; linear law: 1
  double ring;          // m^3, that times the contact's spread; linear law: m^2
  double roll[3];       // m, displacement of rolling; zero if no law resists it

  bool operator<(const History& o) const {
    return first != o.first ? first < o.first : second < o.second;
  }
};

// For searches by the keys: all other members are zero.
inline History history_of_keys(std::int64_t first, std::int64_t second) {
  History keys{};
  keys.first = first, keys.second = second;
  return keys;
}

// Identifies a piece equally on every rank; sorts by particle, then piece. 47 bits remain for the
// id: far more than can be simulated.
inline constexpr int piece_bits = 16;
inline std::int64_t piece_key(Id id, std::size_t piece) {
  return (id << piece_bits) | static_cast<std::int64_t>(piece);
}
inline Id particle_of(std::int64_t key) { return key >> piece_bits; }

}  // namespace trackbed::dem
