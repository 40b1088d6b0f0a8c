// Bonds between stones. Like a contact, a bond is known on the ranks of both of its stones, which
// compute it from identical data; a stone adds the forces of its bonds behind those of contacts, in
// the order of the ids. Bonds move with their stones and are independent of the neighbour lists.
//
// Cost: 90 ns for each bond and sub-step, five times as much as a contact of balls; nothing without
// bonds. Balls, whose attitudes are otherwise not followed, are rotated from the first bond on,
// which takes 30 ns for each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "dem/contact/stone_pair.hpp"
#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/exact_totals.hpp"

namespace trackbed::dem {

BondedBody Particles::Impl::bonded_body(std::size_t b, const Vec3& shift) const {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const bool held = state.held[b] != 0;
  const bool plane = domain.dimension == Dimension::plane;
  const Vec3 inertia = state.inertia[b].vec3();
  return {state.x[b].vec3() + shift, quat(state.q[b]),
          state.v[b].vec3(),         state.w[b].vec3(),
          held ? infinite : mass(b), held ? infinite : (plane ? inertia.y() : inertia.minCoeff())};
}

BondResponse Particles::Impl::respond_to(std::size_t n) const {
  const Bond& bond = bonding.bonds[n];
  const Bonding::Place& at = bonding.places[n];
  return respond(bond, parameters_of(bond), domain, bonded_body(at.i, Vec3::Zero()),
                 bonded_body(at.j, at.shift));
}

// Local. A bond that breaks gives no force in that sub-step; damage counts from the next one on.
void Particles::Impl::compute_bond_forces(const SubStep& step) {
  bool broke = false;
  for (std::size_t n = 0; n < bonding.bonds.size(); ++n) {
    Bond& bond = bonding.bonds[n];
    const auto [i, j, shift] = bonding.places[n];
    const BondParameters& p = parameters_of(bond);
    const BondResponse r = respond_to(n);
    const double worst = utilisation(r, p);
    const double whole = 1 - damage(bond.worst, p);
    if (worst > bond.worst) bond.worst = worst;
    const Vec3 apart = state.x[j].vec3() + shift - state.x[i].vec3();
    const bool torn = apart.norm() > state.x[i].w + state.x[j].w + bond.beyond;
    if (torn) bond.worst = std::numeric_limits<double>::infinity();
    const double left = 1 - damage(bond.worst, p);
    bond.released += (1 - left / whole) * r.energy;
    if (left <= 0) {
      broke = true;
      if (i < state.own)
        bonding.breaks.push_back({elapsed + step.dt * step.number, bond.first, bond.second,
                                  static_cast<int>(bond.kind), !torn && by_shear(r, p), r.point,
                                  r.normal, r.shear, bond.released});
      continue;
    }
    const auto add = [&](std::size_t b, const Vec3& centre, double sign) {
      if (b >= state.own) return;
      const Vec3 force = sign * r.force;
      state.f[b].set(state.f[b].vec3() + force);
      state.f[b].w += step.dt * r.dissipated;
      state.t[b].set(state.t[b].vec3() + (r.point - centre).cross(force) + sign * r.moment);
    };
    add(i, state.x[i].vec3(), 1), add(j, state.x[j].vec3() + shift, -1);
  }
  if (broke) drop_broken_bonds();
}

void Particles::Impl::drop_broken_bonds() {
  std::size_t kept = 0;
  for (std::size_t n = 0; n < bonding.bonds.size(); ++n) {
    const Bond& bond = bonding.bonds[n];
    if (damage(bond.worst, parameters_of(bond)) >= 1) continue;
    bonding.bonds[kept] = bond, bonding.places[kept] = bonding.places[n];
    ++kept;
  }
  bonding.bonds.resize(kept), bonding.places.resize(kept);
}

// In new lists. Bonds of which this rank has neither stone are dropped; both ranks of a bond find
// the same image of the second stone, since positions are unwrapped.
void Particles::Impl::place_bonds() {
  bonding.places.clear();
  if (bonding.bonds.empty()) return;
  std::unordered_map<Id, std::size_t> number;
  for (std::size_t b = 0; b < state.size(); ++b) number.emplace(state.id[b], b);
  std::erase_if(bonding.bonds, [&](const Bond& bond) {
    const auto i = number.find(bond.first), j = number.find(bond.second);
    const auto is_own = [&](const auto& found) {
      return found != number.end() && found->second < state.own;
    };
    if (!is_own(i) && !is_own(j)) return true;
    // No bond becomes that long (`Bond::beyond`), unless its stones have jumped.
    if (i == number.end() || j == number.end()) {
      report(fmt::format(
          "the stones {} and {} were torn apart so fast that their bond is longer than neighbour "
          "lists reach (dem.skin = {:.3g} m); use a smaller dem.safety or time.step",
          bond.first, bond.second, skin));
      return true;
    }
    bonding.places.push_back({i->second, j->second, image_of(i->second, j->second)});
    return false;
  });
}

// m, to be added to the position of j.
Vec3 Particles::Impl::image_of(std::size_t i, std::size_t j) const {
  const Vec3 d = state.x[j].vec3() - state.x[i].vec3();
  Vec3 shift = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    if (!domain.periodic[static_cast<std::size_t>(a)]) continue;
    const double period = domain.high[a] - domain.low[a];
    shift[a] = -std::round(d[a] / period) * period;
  }
  return shift;
}

// Of leaving stones, to the ranks in `goes_to`; copies, since the other stone may stay here.
// Collective.
void Particles::Impl::migrate_bonds(const std::unordered_map<Id, std::size_t>& goes_to) {
  if (!bonding.any) return;
  std::vector<std::vector<Bond>> leaving(static_cast<std::size_t>(comm.size()));
  for (const Bond& bond : bonding.bonds)
    for (const Id id : {bond.first, bond.second})
      if (const auto to = goes_to.find(id); to != goes_to.end())
        leaving[to->second].push_back(bond);
  for (const auto& list : comm.exchange(leaving))
    bonding.bonds.insert(bonding.bonds.end(), list.begin(), list.end());
  sort_bonds();
}

void Particles::Impl::sort_bonds() {
  std::vector<Bond>& bonds = bonding.bonds;
  std::sort(bonds.begin(), bonds.end());
  const auto same = [](const Bond& a, const Bond& b) { return !(a < b) && !(b < a); };
  bonds.erase(std::unique(bonds.begin(), bonds.end(), same), bonds.end());
}

namespace {

// The place where two stones are nearest to each other.
struct Nearest {
  double gap;          // m; below 0: they overlap
  Vec3 point, normal;  // m; unit length, from the first to the second
};
using NearestPairs = std::map<std::pair<std::size_t, std::size_t>, Nearest>;  // by their numbers

void take(NearestPairs& pairs, std::size_t i, std::size_t j, const Nearest& found) {
  const auto [known, added] = pairs.try_emplace({i, j}, found);
  if (!added && found.gap < known->second.gap) known->second = found;
}

}  // namespace

// m, of the ball (in a plane: the disk) with the volume of the stone.
double Particles::Impl::equal_radius(std::size_t b) const {
  const double volume = shapes[state.shape[b]].volume;
  const double radius = domain.dimension == Dimension::plane ? std::sqrt(volume / std::numbers::pi)
                                                             : radius_of(volume);
  return radius * state.scale_now(b);
}

// m, by which a bond may become longer than the balls around both stones and its gap: the same for
// all bonds of a kind, so that it depends on no list. Collective.
double Particles::Impl::longest_stretch() const {
  // Of its radius. A bond of equal balls with a strength of young/100 and a softening of 2 breaks
  // at 0.04.
  constexpr double of_smallest = 0.1;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < state.own; ++b) smallest = std::min(smallest, radius(b));
  smallest = comm.min(smallest);
  return std::isfinite(smallest) ? of_smallest * smallest : 0;
}

// Pairs of stones that may be bonded, from new lists. Contacts of stones with corners are computed
// once, on copies: forces and histories do not change. Local.
void Particles::Impl::find_bonds(std::size_t kind, double stretch, std::vector<Bond>& made) const {
  const BondParameters& p = bonding.parameters[kind];
  NearestPairs found;
  const auto body = [&](std::int32_t piece) {
    return static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]);
  };
  visit_pairs([&](std::int32_t piece, std::int32_t other, const Vec3& d) {
    const Vec4& i = pieces.x[static_cast<std::size_t>(piece)];
    const double distance = d.norm(),
                 gap = distance - i.w - pieces.x[static_cast<std::size_t>(other)].w;
    constexpr double rounding = 1e-9;  // of positions: balls that are placed to touch do
    if (!(gap <= p.gap + rounding * distance) || !(distance > 0)) return;
    const Vec3 normal = d / distance;
    take(found, body(piece), body(other), {gap, i.vec3() + (i.w + gap / 2) * normal, normal});
  });
  if (!stones.entries.empty()) {
    State moved = state;
    StoneList list = stones;
    StoneContacts contacts;
    contacts.reset(scene(), list);
    constexpr double instant = 1e-12;  // s: histories of the copy are of no interest
    contacts.compute_forces(scene(), instant, list, moved);
    for (const Overlap& o : contacts.overlaps(scene(), list)) {
      const std::size_t i = body(o.piece);
      take(found, i, body(list.entries[o.entry].piece),
           {-o.wrench.M, state.x[i].vec3() + o.wrench.x, o.wrench.N.normalized()});
    }
  }
  const int material = p.material.empty() ? -1 : physics.material(p.material);
  for (const auto& [stones_of, nearest] : found) {
    const auto [i, j] = stones_of;
    if (material >= 0 && (state.material[i] != material || state.material[j] != material)) continue;
    if (!within_box(p, nearest.point)) continue;
    const double radius = p.radius * std::min(equal_radius(i), equal_radius(j));
    const BondedBody one = bonded_body(i, Vec3::Zero()), other = bonded_body(j, image_of(i, j));
    made.push_back(make_bond(state.id[i], state.id[j], static_cast<int>(kind), one, other,
                             nearest.point, nearest.normal, radius));
    made.back().beyond = p.gap + stretch;
  }
}

// A point, brought into the domain, in the box of the parameters.
bool Particles::Impl::within_box(const BondParameters& p, Vec3 point) const {
  if (p.low.size() != 3 || p.high.size() != 3) return true;
  for (int a = 0; a < 3; ++a) {
    if (domain.periodic[static_cast<std::size_t>(a)]) {
      const double period = domain.high[a] - domain.low[a];
      point[a] -= std::floor((point[a] - domain.low[a]) / period) * period;
    }
    const auto axis = static_cast<std::size_t>(a);
    const bool plane = domain.dimension == Dimension::plane && a == 1;
    if (!plane && (point[a] < p.low[axis] || point[a] > p.high[axis])) return false;
  }
  return true;
}

void Particles::set_bonds(std::vector<BondParameters> parameters) {
  impl_->bonding.parameters = std::move(parameters);
}

// Collective. Pairs that are bonded already are left as they are.
std::int64_t Particles::bond(std::size_t kind) {
  Impl& r = *impl_;
  require(kind < r.bonding.parameters.size(), "the kind of bonds is known");
  require(r.state.grown >= 1, "stones that still grow are not bonded");
  const double stretch = r.longest_stretch();
  r.bonding.any = true;
  r.bonding.longest = std::max(r.bonding.longest, r.bonding.parameters[kind].gap + stretch);
  repartition();  // lists reach as far as bonds
  r.rebuild();
  std::vector<Bond> made;
  r.find_bonds(kind, stretch, made);
  std::erase_if(made, [&](const Bond& bond) {
    return std::binary_search(r.bonding.bonds.begin(), r.bonding.bonds.end(), bond);
  });
  std::int64_t count = 0;
  for (const Bond& bond : made) count += r.own_number(bond.first) ? 1 : 0;
  count = r.comm.sum(count);
  r.bonding.bonds.insert(r.bonding.bonds.end(), made.begin(), made.end());
  r.sort_bonds();
  r.place_bonds();
  r.bonding.made += count;
  return count;
}

void Particles::bonds(const std::function<void(const BondView&)>& visit) const {
  const Impl& r = *impl_;
  for (std::size_t n = 0; n < r.bonding.places.size(); ++n) {
    const Bond& bond = r.bonding.bonds[n];
    const auto& [i, j, shift] = r.bonding.places[n];
    if (i >= r.state.own) continue;
    const BondParameters& p = r.parameters_of(bond);
    const BondResponse now = r.respond_to(n);
    visit({bond.first, bond.second, static_cast<int>(bond.kind), r.state.x[i].vec3(),
           r.state.x[j].vec3() + shift, now.point, now.elastic, now.twisting, utilisation(now, p),
           damage(bond.worst, p), now.energy});
  }
}

std::int64_t Particles::bonds_of(std::size_t kind) const {
  const Impl& r = *impl_;
  std::int64_t count = 0;
  for (const Bond& bond : r.bonding.bonds)
    count += bond.kind == static_cast<std::int64_t>(kind) && r.own_number(bond.first) ? 1 : 0;
  return r.comm.sum(count);
}

const std::vector<BondBreak>& Particles::bond_breaks() const { return impl_->bonding.breaks; }

// Sums are exact: the same for any number of ranks.
BondTotals Particles::bonded() const {
  const Impl& r = *impl_;
  BondTotals total;
  total.made = r.bonding.made;
  for (const Bond& bond : r.bonding.bonds) total.whole += r.own_number(bond.first) ? 1 : 0;
  for (const BondBreak& each : r.bonding.breaks)
    ++(each.by_shear ? total.by_shear : total.by_tension);
  total.whole = r.comm.sum(total.whole);
  total.by_tension = r.comm.sum(total.by_tension), total.by_shear = r.comm.sum(total.by_shear);
  std::vector<double> released;
  for (const BondBreak& each : r.bonding.breaks) released.push_back(each.energy);
  for (const Bond& bond : r.bonding.bonds)
    if (r.own_number(bond.first)) released.push_back(bond.released);
  total.released = par::exact_totals(r.comm, {}, released.size(), [&](std::size_t k) {
    return par::ExactTerm{0, released[k]};
  })[0];
  return total;
}

// s. With the largest frequency w of the springs and the largest rate 2 z w of the dampers, an
// explicit scheme is stable up to 2/w (sqrt(1 + z^2) - z). Both are bounded by the sums over the
// bonds of each stone: two stones that move against each other double them, and translation and
// rotation add up. Infinite without bonds. Local.
double Particles::Impl::stable_step_of_bonds() const {
  struct Sums {
    double pull = 0, turn = 0;   // N/m, Nm/rad
    double slow = 0, brake = 0;  // N s/m, Nm s
  };
  std::vector<Sums> sums(state.own);
  for (const Bond& bond : bonding.bonds) {
    const BondParameters& p = parameters_of(bond);
    const BondStiffness k = stiffness_of(bond, p, domain);
    const double along = std::max(k.normal, k.shear), about = std::max(k.bending, k.torsion);
    int side = 0;
    for (const Id id : {bond.first, bond.second}) {
      const double arm = Eigen::Map<const Vec3>(bond.arm[side++]).squaredNorm();
      const auto b = own_number(id);
      if (!b || state.held[*b] != 0) continue;
      // With the stone's own mass and inertia, which are not less than the reduced ones.
      const BondedBody body = bonded_body(*b, Vec3::Zero());
      const double slow = 2 * p.damping * std::sqrt(along * body.mass);
      const double brake = 2 * p.damping * std::sqrt(about * body.inertia);
      Sums& sum = sums[*b];
      sum.pull += along, sum.turn += about + along * arm;
      sum.slow += slow, sum.brake += brake + slow * arm;
    }
  }
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < state.own; ++b) {
    const Sums& sum = sums[b];
    if (sum.pull == 0) continue;
    const BondedBody body = bonded_body(b, Vec3::Zero());
    const double w = std::sqrt(2 * (sum.pull / body.mass + sum.turn / body.inertia));
    const double z = (sum.slow / body.mass + sum.brake / body.inertia) / w;
    step = std::min(step, 2 / w * (std::sqrt(1 + z * z) - z));
  }
  return parameters.safety * step;
}

}  // namespace trackbed::dem
