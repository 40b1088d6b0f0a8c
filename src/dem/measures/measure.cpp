// Evaluation of the particles' state; nothing here changes it. Sums over ranks are exact
// (core/exact_sum.hpp): bitwise identical for any number of ranks. Each evaluation costs as much as
// a sub-step or more, so it is done at the rows of the results and not in each sub-step.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "dem/particles/contact_loop.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/geom/stone.hpp"
#include "trackbed/par/exact_totals.hpp"

namespace trackbed::dem {

// Spin from the angular momentum and not from `w`, which in the force loop is that of half a
// sub-step earlier: all values are at one time level.
ParticleView Particles::operator[](std::size_t b) const {
  const State& s = impl_->state;
  const Quat q = quat(s.q[b]);
  const Vec3 body = q.conjugate() * s.l[b].vec3();
  const double scale_of_mass = s.is_fragment(b) ? s.scale[b] : s.scale_now(b);
  return {s.id[b], static_cast<int>(s.shape[b]), static_cast<int>(s.material[b]), s.scale_now(b),
          s.v[b].w,
          // Of a fragment those of its final size, to which its mass belongs.
          mass_of(impl_->shapes[s.shape[b]], scale_of_mass, 1, impl_->domain),
          impl_->shapes[s.shape[b]].sieve * scale_of_mass, s.x[b].w, s.x[b].vec3(), s.v[b].vec3(),
          q * Vec3(body.cwiseQuotient(s.inertia[b].vec3())), s.f[b].vec3(), s.t[b].vec3(), q,
          s.l[b].vec3(), s.held[b] != 0, s.is_fragment(b)};
}

void Particles::pieces(std::size_t b, const std::function<void(const Vec3&, double)>& visit) const {
  const State& s = impl_->state;
  const Quat q = quat(s.q[b]);
  for (std::size_t k = impl_->shapes.begin(s.shape[b]); k < impl_->shapes.end(s.shape[b]); ++k) {
    const Vec4& piece = impl_->shapes.piece(k);
    visit(s.x[b].vec3() + s.scale_now(b) * (q * piece.vec3()), s.scale_now(b) * piece.w);
  }
}

void Particles::corners(std::size_t b,
                        const std::function<void(const Vec3&, double)>& visit) const {
  const State& s = impl_->state;
  const Quat q = quat(s.q[b]);
  for (std::size_t k = impl_->shapes.begin(s.shape[b]); k < impl_->shapes.end(s.shape[b]); ++k) {
    const Core& core = impl_->shapes.core(k);
    for (const Vec4& corner : core.corners)
      visit(s.x[b].vec3() + s.scale_now(b) * (q * corner.vec3()), s.scale_now(b) * core.radius);
  }
}

namespace {

// Unit vectors from the corners of a core into the cone of normals there: moved along it by the
// rounding, a corner lies on the rounded surface.
std::vector<Vec3> outwards(const geom::Convex& core, bool flat) {
  std::vector<Vec3> found(core.vertices.size(), Vec3::Zero());
  for (const geom::Face& face : core.faces) {
    const std::size_t n = face.vertices.size();
    for (std::size_t k = 0; k < n; ++k) {
      const auto at = [&](std::size_t i) {
        return core.vertices[static_cast<std::size_t>(face.vertices[i % n])];
      };
      // The bisector of a flat piece's edges is the sum of the directions that lead to the corner.
      found[static_cast<std::size_t>(face.vertices[k])] +=
          flat ? Vec3((at(k) - at(k + 1)).normalized() + (at(k) - at(k + n - 1)).normalized())
               : face.normal;
    }
  }
  for (Vec3& direction : found) direction.normalize();
  return found;
}

}  // namespace

void Particles::outlines(std::size_t b,
                         const std::function<void(const PieceOutline&)>& visit) const {
  const State& s = impl_->state;
  const Quat q = quat(s.q[b]);
  const auto in_space = [&](const Vec3& point) -> Vec3 {
    return s.x[b].vec3() + s.scale_now(b) * (q * point);
  };
  std::size_t k = impl_->shapes.begin(s.shape[b]);
  for (const geom::Piece& piece : impl_->shapes[s.shape[b]].pieces) {
    const Vec4& ball = impl_->shapes.piece(k);
    const bool flat = impl_->shapes.core(k++).flat;
    PieceOutline outline{in_space(ball.vec3()), s.scale_now(b) * ball.w, {}, {}};
    const std::vector<Vec3> out = outwards(piece.core, flat);
    for (std::size_t c = 0; c < out.size() && !piece.core.faces.empty(); ++c)
      outline.corners.push_back(in_space(piece.core.vertices[c] + piece.radius * out[c]));
    for (const geom::Face& face : piece.core.faces) {
      outline.faces.push_back(face.vertices);
      if (flat) break;  // its other face is the same polygon
    }
    visit(outline);
  }
}

// Made at the first use: 12 kB for each template.
void Particles::points(std::size_t b, const std::function<void(const Vec3&)>& visit) const {
  const State& s = impl_->state;
  const auto shape = static_cast<std::size_t>(s.shape[b]);
  auto& known = impl_->points_of_shape;
  if (known.size() <= shape) known.resize(shape + 1);
  if (known[shape].empty())
    known[shape] = geom::points_within(impl_->shapes[s.shape[b]], points_of_particle,
                                       impl_->domain.dimension == Dimension::plane);
  // A matrix: it takes half of the operations that a quaternion takes for each point.
  const Mat3 turned = s.scale_now(b) * quat(s.q[b]).toRotationMatrix();
  const Vec3 centre = s.x[b].vec3();
  for (const Vec3& point : known[shape]) visit(centre + turned * point);
}

void Particles::contacts(const std::function<void(const ContactView&)>& visit) const {
  const Impl& r = *impl_;
  ContactLoop(r).run([&](const ContactView& view, auto...) { visit(view); });
}

namespace {

// All sums in Totals at once. A list of terms and not running sums: the range of an exact sum must
// be known before the first term is added.
class Sums {
 public:
  explicit Sums(std::size_t terms = 0) { terms_.reserve(terms); }  // about as many are added

  // The last two have three components. Those of energies come first.
  enum Of : std::size_t { kinetic, potential, elastic, mass, net, contact, momentum, force = 9 };
  static constexpr std::size_t energies = mass, all = force + 3;  // numbers of sums

  void add(Of sum, double term) { terms_.push_back({sum, term}); }
  void add(Of sum, const Vec3& term) {
    for (std::size_t a = 0; a < 3; ++a) terms_.push_back({sum + a, term[static_cast<int>(a)]});
  }
  void add_energies(const State& s, std::size_t b, double g) {
    const double mass = s.v[b].w;
    const Vec3 body = quat(s.q[b]).conjugate() * s.l[b].vec3();  // angular momentum
    add(kinetic, 0.5 * mass * s.v[b].vec3().squaredNorm() +
                     0.5 * body.dot(body.cwiseQuotient(s.inertia[b].vec3())));
    add(potential, mass * g * s.x[b].z);
  }
  void add(const ParticleView& p, double g) {
    add(mass, p.mass);
    // Gravity is not in the stored force. The force that holds a held particle balances all forces
    // on it.
    add(net, p.held ? 0 : (p.force - Vec3(0, 0, p.mass * g)).norm());
    add(momentum, p.mass * p.velocity);
  }
  void add(const ContactView& c, double energy) {
    add(elastic, energy);
    add(contact, c.force.norm());
    if (c.second < 0) add(force, -c.force);  // of surfaces only
  }
  // Collective; before the following. `count`: of the sums, from the first one.
  void complete(const par::Comm& comm, std::size_t count) {
    sums_ = par::exact_totals(comm, {count, count}, terms_.size(),
                              [&](std::size_t k) { return terms_[k]; });
  }
  double operator[](Of sum) const { return sums_[sum]; }
  Vec3 vector(Of sum) const { return {sums_[sum], sums_[sum + 1], sums_[sum + 2]}; }

 private:
  std::vector<par::ExactTerm> terms_;
  std::vector<double> sums_;
};

double mean(double sum, std::int64_t count) {
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace

EnergyAccount Particles::Impl::total_of(std::span<const Vec4> accounts) const {
  constexpr std::size_t columns = 4;
  const auto term = [&](std::size_t k) {
    const Vec4& a = accounts[k / columns];
    return par::ExactTerm{k % columns, std::array{a.x, a.y, a.z, a.w}[k % columns]};
  };
  const auto sums = par::exact_totals(comm, {columns, columns}, columns * accounts.size(), term);
  return {sums[0], sums[1], sums[2], sums[3]};
}

std::optional<EnergyAccount> Particles::Impl::energy_account() const {
  if (!parameters.energy_balance) return {};
  EnergyAccount sum = total_of(std::span(state.account).first(state.own));
  sum += removed;
  return sum;
}

Energies Particles::energies() const {
  const Impl& r = *impl_;
  Sums sums(6 * r.state.own);  // two of a particle, one of each contact
  for (std::size_t b = 0; b < r.state.own; ++b) sums.add_energies(r.state, b, r.parameters.gravity);
  ContactLoop(r).run(
      [&](const ContactView&, double energy, auto...) { sums.add(Sums::elastic, energy); });
  bonds([&](const BondView& bond) { sums.add(Sums::elastic, bond.energy); });
  sums.complete(r.comm, Sums::energies);
  return {sums[Sums::kinetic], sums[Sums::potential], sums[Sums::elastic], r.energy_account()};
}

// `unbalanced` is 1 without contacts: free fall is not equilibrium.
Totals Particles::totals() const {
  const Impl& r = *impl_;
  Totals total;
  Sums sums;
  for (std::size_t b = 0; b < r.state.own; ++b) {
    const ParticleView p = (*this)[b];
    sums.add_energies(r.state, b, r.parameters.gravity);
    sums.add(p, r.parameters.gravity);
    total.pieces += static_cast<std::int64_t>(r.shapes.end(p.shape) - r.shapes.begin(p.shape));
  }
  ContactLoop(r).run([&](const ContactView& c, double energy, auto...) {
    ++total.contacts;
    total.largest_overlap = std::max(total.largest_overlap, c.overlap);
    sums.add(c, energy);
  });
  bonds([&](const BondView& bond) { sums.add(Sums::elastic, bond.energy); });
  total.particles = r.comm.sum(static_cast<std::int64_t>(r.state.own));
  total.pieces = r.comm.sum(total.pieces);
  total.contacts = r.comm.sum(total.contacts);
  total.largest_overlap = r.comm.max(total.largest_overlap);
  sums.complete(r.comm, Sums::all);
  total.mass = sums[Sums::mass], total.kinetic = sums[Sums::kinetic];
  total.potential = sums[Sums::potential], total.elastic = sums[Sums::elastic];
  total.account = r.energy_account();
  total.momentum = sums.vector(Sums::momentum);
  total.surface_force = sums.vector(Sums::force);
  const double mean_contact = mean(sums[Sums::contact], total.contacts);
  const double mean_net = mean(sums[Sums::net], total.particles);
  total.unbalanced = mean_contact > 0 ? mean_net / mean_contact : 1;
  return total;
}

// Two particles may be in contact with many pieces, all of them counted on the same rank. A surface
// has no neighbours of its own.
std::int64_t Particles::neighbours() const {
  std::vector<std::pair<Id, Id>> touching;
  ContactLoop(*impl_).run(
      [&](const ContactView& c, auto...) { touching.emplace_back(c.first, c.second); });
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  std::int64_t count = 0;
  for (const auto& [first, second] : touching) count += second < 0 ? 1 : 2;
  return impl_->comm.sum(count);
}

// All data that determine the further motion: poses, motion and histories, with the names of their
// objects. Forces are left out, as they follow from these. Sums of hashes wrap around, so the order
// does not matter.
std::uint64_t Particles::state_hash() const {
  Impl& r = *impl_;
  std::uint64_t sum = 0;
  for (std::size_t b = 0; b < r.state.own; ++b) {
    const State& s = r.state;
    std::uint64_t h = hash_bytes(&s.id[b], sizeof s.id[b]);
    h = hash_bytes(&s.x[b], 3 * sizeof(double), h);
    h = hash_bytes(&s.q[b], sizeof s.q[b], h);
    h = hash_bytes(&s.v[b], 3 * sizeof(double), h);
    h = hash_bytes(&s.l[b], 3 * sizeof(double), h);
    if (s.held[b] != 0) h = hash_bytes(&s.held[b], sizeof s.held[b], h);
    if (s.is_fragment(b)) h = hash_bytes(&s.part[b], sizeof s.part[b], h);
    if (s.rubbed[b] != 0) h = hash_bytes(&s.rubbed[b], sizeof s.rubbed[b], h);
    sum += mix(h);
  }
  for (const std::vector<History>& records : {r.history(), r.waiting})
    for (const History& record : records) {
      const Id first = particle_of(record.first);
      const auto end = r.state.id.begin() + static_cast<std::ptrdiff_t>(r.state.own);
      if (std::binary_search(r.state.id.begin(), end, first))
        sum += mix(hash_bytes(&record, sizeof record));
    }
  for (const Bond& bond : r.bonding.bonds)
    if (r.own_number(bond.first)) sum += mix(hash_bytes(&bond, sizeof bond));
  return static_cast<std::uint64_t>(r.comm.sum(static_cast<std::int64_t>(sum)));
}

// Memory that is reserved, used or not. Local.
Memory Particles::memory() const {
  const Impl& r = *impl_;
  Memory memory;
  std::size_t* to = &memory.particles;
  const auto count = [&](const auto&... arrays) {
    ((*to += arrays.capacity() * sizeof(arrays[0])), ...);
  };
  visit_all(r.state, [&](auto, auto& array) { count(array); });
  count(r.reference_x, r.reference_q);
  count(r.pieces.x, r.pieces.body, r.pieces.begin);
  count(r.pieces.core, r.pieces.rounding, r.pieces.turns);
  count(r.pieces.last_x, r.pieces.last_q, r.pieces.path);
  count(r.pieces.pace, r.pieces.last_path);
  to = &memory.contacts;
  for (const PairList* list : {&r.pairs, static_cast<const PairList*>(&r.stones)})
    count(list->rows, list->entries, list->xi, list->roll, list->size);
  count(r.near.blocks, r.near.size, r.near.roll, r.near.limit, r.near_pieces, r.breaking.strength);
  count(r.stones.turn, r.approaches);
  for (const Approach& a : r.approaches) count(a.triangles, a.patches, a.near.features);
  count(r.bonding.bonds, r.bonding.places);
  memory.contacts += r.stone_contacts.memory();
  return memory;
}

}  // namespace trackbed::dem
