// Stones with corners are cut by planes, in the order of their numbers: every rank derives the same
// shapes and gives the same numbers, whoever owns the stones.
//
// The parts of a split stone are born without contact: each is as much smaller than the cut leaves
// it as its contacts were compressed, so that they displace nothing, and the elastic energy of all
// contacts of the stone is released. What is lost by this and along the new rounded edges is fines.
// The larger part keeps the number of the stone.
//
// Parts move as the points of the stone did: momentum, angular momentum and energy of all parts and
// fines together are those of the stone.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "dem/particles/impl.hpp"

namespace trackbed::dem {

// Of all ranks, each stone once. A stone that changed its owner is reported by the last one only.
std::vector<Cut> Particles::Impl::gather_cuts() {
  std::vector<Cut> all = comm.all_gather(std::span<const Cut>(breaking.cuts));
  breaking.cuts.clear();
  std::sort(all.begin(), all.end(),
            [](const Cut& one, const Cut& other) { return one.stone < other.stone; });
  return all;
}

// Adds a row for each part with a mass (kg); energies belong to the first.
void Particles::Impl::record(const Cut& cut, const Vec3& place, double lost,
                             std::initializer_list<std::pair<Id, double>> parts) {
  Break row{elapsed, cut.stone, -1, 0, place, 0, 0, cut.force, cut.energy, lost};
  row.kind = static_cast<BreakKind>(cut.kind), row.stress = cut.stress;
  for (const auto& [fragment, mass] : parts) {
    if (!(mass > 0)) continue;
    row.fragment = fragment, row.mass = mass;
    row.diameter = row.kind == BreakKind::wear ? 0 : 2 * radius_of(mass / cut.density);
    breaking.breaks.push_back(row);
    row.released = row.lost = 0;
  }
}

// One stone, on every rank; its owner divides it. Returns the kinetic energy that is lost, J, on
// the owner, else 0.
double Particles::Impl::cut_off(const Cut& cut, std::unordered_map<Id, Changed>& stones) {
  const auto kind = static_cast<BreakKind>(cut.kind);
  auto parts = parts_of(shapes[cut.shape], cut);
  const auto mass_of_part = [&](std::size_t side) {
    const double scale = cut.scale * cut.size[side];
    return parts[side] ? cut.density * parts[side]->stone.volume * scale * scale * scale : 0;
  };
  const double whole = cut.density * shapes[cut.shape].volume * std::pow(cut.scale, 3);
  // Volumes of several pieces are integrated, and parts may seem larger than the whole.
  if (const double excess = (mass_of_part(0) + mass_of_part(1)) / whole; excess > 1)
    for (auto& part : parts)
      if (part) part->stone.volume /= excess;
  const std::size_t main = kind == BreakKind::split && mass_of_part(1) > mass_of_part(0) ? 1 : 0;
  const std::size_t other = 1 - main;
  const double other_mass = mass_of_part(other);
  const bool keeps = parts[other] && other_mass >= breaking.least_mass;
  const double fines = std::max(whole - mass_of_part(main) - (keeps ? other_mass : 0), 0.0);
  const auto count = shapes.end(cut.shape) - shapes.begin(cut.shape);
  const std::int64_t splits =
      shapes.label(shapes.begin(cut.shape)) + (kind == BreakKind::split ? 1 : 0);
  const auto add_shape = [&](std::size_t side) -> std::int64_t {
    geom::Template& stone = parts[side]->stone;
    // Costs ten times as much as the cut; without a corner a stone passes nearly the same hole.
    stone.sieve =
        kind == BreakKind::split ? geom::smallest_hole(stone.pieces) : shapes[cut.shape].sieve;
    if (kind == BreakKind::wear && breaking.single.contains(cut.shape)) {
      shapes.replace(cut.shape, stone);
      const auto shape = static_cast<std::size_t>(cut.shape);
      if (shape < points_of_shape.size()) points_of_shape[shape].clear();
      return cut.shape;
    }
    const std::int64_t shape =
        shapes.add(stone, std::vector<std::int64_t>(stone.pieces.size(), splits));
    breaking.single.insert(shape);
    return shape;
  };
  Changed changed{add_shape(main), std::vector<std::int64_t>(count, -1)};
  // Pieces are where they were, and so are their contacts; a plane may have removed one of several.
  if (kind == BreakKind::wear || (kind == BreakKind::cut && count == 1))
    std::iota(changed.pieces.begin(), changed.pieces.end(), std::int64_t{0});
  NewPart rest{*parts[main], changed.shape, cut.size[main], -1}, piece{};
  if (keeps) piece = {*parts[other], add_shape(other), cut.size[other], breaking.next++};
  double lost = 0;
  if (const auto b = own_number(cut.stone)) {
    // Of the other part; a crushed corner is recorded at the centre of its stone.
    const Vec3 at = parts[other] ? parts[other]->centre : Vec3::Zero();
    const Vec3 place = state.x[*b].vec3() + quat(state.q[*b]) * Vec3(cut.scale * at);
    lost = divide(*b, rest, keeps ? &piece : nullptr, kind == BreakKind::split);
    if (kind == BreakKind::wear) state.rubbed[*b] = 0;
    record(cut, place, lost, {{piece.id, keeps ? other_mass : 0}, {-1, fines}});
  }
  BreakTotals& totals = breaking.totals;
  ++(kind == BreakKind::split ? totals.splits
     : kind == BreakKind::cut ? totals.cuts
                              : totals.wears);
  if (kind == BreakKind::wear) totals.dust_mass += fines;
  if (keeps) ++totals.fragments, totals.fragment_mass += other_mass;
  if (fines > 0) ++totals.fines, totals.fines_mass += fines;
  totals.released += cut.energy;
  stones.emplace(cut.stone, std::move(changed));
  return lost;
}

// Stone b becomes the first part, and the second is added, if there is one. `split`: contacts of
// all parts are gone, and the force in the half kick to come is divided by mass;
// otherwise the first part keeps it. Returns the kinetic energy that is lost, J.
double Particles::Impl::divide(std::size_t b, const NewPart& rest, const NewPart* piece,
                               bool split) {
  const double scale = state.scale[b], whole = mass(b);
  const Quat q = quat(state.q[b]);
  const Vec3 x = state.x[b].vec3(), v = state.v[b].vec3(), momentum = state.l[b].vec3();
  const Vec3 spin = q * Vec3((q.conjugate() * momentum).cwiseQuotient(state.inertia[b].vec3()));
  const Vec3 force = state.f[b].vec3(), torque = state.t[b].vec3();
  double energy = 0.5 * whole * v.squaredNorm() + 0.5 * momentum.dot(spin);
  const auto become = [&](std::size_t k, const NewPart& part) {
    const Vec3 arm = q * Vec3(scale * part.of.centre);
    state.shape[k] = part.shape, state.scale[k] = scale * part.size;
    state.x[k].set(x + arm), state.v[k].set(v + spin.cross(arm));
    state.q[k] = vec4((q * part.of.axes).normalized());
    derive_one(k);
    const Quat axes = quat(state.q[k]);
    const Vec3 body = (axes.conjugate() * spin).cwiseProduct(state.inertia[k].vec3());
    state.l[k].set(axes * body);
    const double share = split ? mass(k) / whole : 1;
    state.f[k].set(share * force);
    state.t[k].set(split ? Vec3(Vec3::Zero()) : Vec3(torque - arm.cross(force)));
    derive_one(k);
    energy -= 0.5 * mass(k) * state.v[k].vec3().squaredNorm() + 0.5 * state.l[k].vec3().dot(spin);
  };
  if (piece) {
    const std::int64_t material = state.material[b];
    visit_all(state, [](auto, auto& array) { array.emplace_back(); });
    state.id.back() = piece->id, state.material.back() = material;
    state.part.back() = 0;
    state.own = state.size();
    become(state.own - 1, *piece);
    if (!split) state.f.back().set(Vec3::Zero()), state.t.back().set(Vec3::Zero());
  }
  become(b, rest);
  return energy;
}

}  // namespace trackbed::dem
