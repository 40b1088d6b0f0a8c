// Breakage of the corners of clumps (Chen et al. 2023, doi:10.1016/j.compgeo.2022.105105): which
// pebbles can break off, and which are overloaded. break_off.cpp: what becomes of their stones;
// fragment_growth.cpp: how fragments grow.
//
// A pebble is overloaded if the normal spring of one of its contacts has more force than the pebble
// has strength. The pair loop compares overlaps, which it has anyway, with the overlap at that
// force. Overloaded pebbles of all ranks break off together at the begin of the next window.
//
// Cost when nothing breaks: a limit of eight numbers for each block of pairs (near_pairs.hpp), and
// the strengths of weak pebbles whenever lists are made.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::dem {

namespace {

// Of the largest radius when stones begin to break: a clump of which every corner on one side
// breaks off has its centre of mass moved by less than this, and no part of a split stone reaches
// farther from its own centre of mass.
constexpr double remainder_room = 1.5;

}  // namespace

double weibull_factor(std::uint64_t seed, std::uint64_t key, double modulus) {
  const double survival = std::clamp(uniform(seed, key), 0x1.0p-54, 1 - 0x1.0p-53);  // in (0, 1)
  return std::pow(-std::log(survival), 1 / modulus);
}

double strength_of(const BreakageParameters& p, Id stone, std::int64_t pebble, double diameter) {
  const auto key = static_cast<std::uint64_t>(piece_key(stone, static_cast<std::size_t>(pebble)));
  return p.strength * diameter * diameter * std::pow(diameter / p.diameter, p.size_exponent) *
         weibull_factor(static_cast<std::uint64_t>(p.seed), key, p.weibull);
}

double least_fragment(const BreakageParameters& p, const Material& material) {
  if (p.least_size == 0) return std::numeric_limits<double>::infinity();
  return material.density * ball_volume(p.least_size / 2);
}

void Particles::set_breakage(const BreakageParameters& parameters) {
  Impl& r = *impl_;
  r.breaking.parameters = parameters;
  r.breaking.material = r.physics.material(parameters.material);
}

// Collective. The least mass is chosen once: later the lightest stone may be a fragment. So is the
// largest radius that the search allows for: a stone that loses corners on one side has its centre
// of mass farther from the other side.
void Particles::let_break(bool active) {
  Impl& r = *impl_;
  if (!active) r.breaking.cracks.clear(), r.breaking.cuts.clear(), r.breaking.pending = 0;
  if (active == r.breaking.active) return;
  if (active && r.shapes.any_stones() && r.breaking.parameters.of_clumps())
    throw RunError(
        "there are stones with corners, from which no pebbles break off: give "
        "breakage.strength = 0, or clumps");
  if (const std::int64_t bonds = active ? bonded().whole : 0; bonds > 0)
    throw InputError({fmt::format(
        "breakage: there are {} bonds between stones, and stones with bonds cannot break; leave "
        "out [breakage]",
        bonds)});
  require(!active || (r.domain.dimension == Dimension::space && r.breaking.material >= 0),
          "only stones of a known material break, in space");
  r.breaking.active = active;
  double lightest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t b = 0; b < r.state.own; ++b) {
    if (r.state.held[b] == 0) lightest = std::min(lightest, r.mass(b));
    largest = std::max(largest, r.radius(b));
  }
  lightest = r.comm.min(lightest), largest = r.comm.max(largest);
  if (active)
    r.breaking.largest_radius = std::max(r.breaking.largest_radius, remainder_room * largest);
  if (active && r.breaking.least_mass == 0 && std::isfinite(lightest)) {
    const Material& material = r.physics.materials[static_cast<std::size_t>(r.breaking.material)];
    const double given = least_fragment(r.breaking.parameters, material);
    r.breaking.least_mass = std::isfinite(given) ? given : lightest;
    r.breaking.least_radius = radius_of(r.breaking.least_mass / material.density);
  }
  repartition();  // lists need strengths, cells the largest radius
}

const std::vector<Break>& Particles::breaks() const { return impl_->breaking.breaks; }
BreakTotals Particles::broken() const { return impl_->breaking.totals; }

// Calls visit(piece of the templates) for the pebbles of particle b that can break off.
template <class Visit>
void Particles::Impl::visit_weak(std::size_t b, Visit&& visit) const {
  const std::size_t begin = shapes.begin(state.shape[b]), end = shapes.end(state.shape[b]);
  if (end - begin < 2 || state.material[b] != breaking.material || state.held[b] != 0) return;
  double largest = 0;
  for (std::size_t k = begin; k < end; ++k) largest = std::max(largest, shapes.piece(k).w);
  for (std::size_t k = begin; k < end; ++k)
    if (shapes.piece(k).w < breaking.parameters.threshold * largest) visit(k);
}

// Local; of ghosts as well: the limit of a pair is that of the weaker piece.
void Particles::Impl::find_strengths() {
  const BreakageParameters& p = breaking.parameters;
  breaking.strength.clear();
  if (!breaking.active || p.strength == 0) return;
  breaking.strength.assign(pieces.body.size(), std::numeric_limits<double>::infinity());
  for (std::size_t b = 0; b < state.size(); ++b)
    visit_weak(b, [&](std::size_t k) {
      breaking.strength[pieces.begin[b] + k - shapes.begin(state.shape[b])] =
          strength_of(p, state.id[b], shapes.label(k), 2 * shapes.piece(k).w * state.scale[b]);
    });
}

std::int64_t Particles::weak_pebbles() const {
  if (!impl_->breaking.active || !impl_->breaking.parameters.of_clumps()) return -1;
  std::int64_t count = 0;
  for (std::size_t b = 0; b < size(); ++b) impl_->visit_weak(b, [&](std::size_t) { ++count; });
  return impl_->comm.sum(count);
}

// The force of the normal spring at this overlap decides.
void Particles::Impl::watch(std::size_t piece, const Law& law, double radius, double overlap) {
  const double strength = breaking.strength[piece];
  const auto b = static_cast<std::size_t>(pieces.body[piece]);
  if (b >= state.own || std::isinf(strength)) return;
  const double force = coefficients<true>(law.springs, overlap, 0.0, radius).k_n * overlap;
  if (!(force > strength)) return;
  const std::size_t k = shapes.begin(state.shape[b]) + piece - pieces.begin[b];
  const double density = physics.materials[static_cast<std::size_t>(state.material[b])].density;
  const double energy = stored_energy(law, overlap, radius, {});
  const Crack crack{state.id[b], shapes.label(k), state.shape[b], state.scale[b],
                    density,     force,           overlap,        energy};
  for (Crack& known : breaking.cracks) {
    if (known.stone != crack.stone || known.pebble != crack.pebble) continue;
    if (std::pair(force, overlap) > std::pair(known.force, known.overlap)) known = crack;
    return;
  }
  breaking.cracks.push_back(crack);
}

// Pairs of blocks in which a limit was exceeded in this sub-step.
void Particles::Impl::watch_near_pairs() {
  for (const std::size_t n : near.over) {
    const PairBlock& block = near.blocks[n];
    for (std::size_t k = 0; k < lanes; ++k) {
      if (block.touches[k] == 0) continue;
      const auto i = static_cast<std::size_t>(block.i[k]), j = static_cast<std::size_t>(block.j[k]);
      const double reach = block.ri[k] + block.rj[k], radius = block.ri[k] * block.rj[k] / reach;
      const Vec3 d = pieces.x[j].vec3() - pieces.x[i].vec3() +
                     near.shifts[static_cast<std::size_t>(block.shift[k])].vec3();
      for (const std::size_t piece : {i, j})
        watch(piece, laws[block.law[k]], radius, reach - d.norm());
    }
  }
}

// Of stones that are removed. Collective.
void Particles::Impl::forget_cracks(const std::vector<Id>& gone) {
  if (breaking.pending == 0) return;
  std::erase_if(breaking.cracks, [&](const Crack& crack) {
    return std::binary_search(gone.begin(), gone.end(), crack.stone);
  });
  std::erase_if(breaking.cuts, [&](const Cut& cut) {
    return std::binary_search(gone.begin(), gone.end(), cut.stone);
  });
  breaking.pending = comm.sum(breaking.waiting());
}

// Of all ranks, each pebble once, by stone and pebble. A stone that changed its owner within the
// window may be reported twice.
std::vector<Crack> Particles::Impl::gather_cracks() {
  std::vector<Crack> all = comm.all_gather(std::span<const Crack>(breaking.cracks));
  breaking.cracks.clear();
  const auto key = [](const Crack& c) { return std::pair(c.stone, c.pebble); };
  std::sort(all.begin(), all.end(), [&](const Crack& one, const Crack& other) {
    if (key(one) != key(other)) return key(one) < key(other);
    return std::pair(one.force, one.overlap) > std::pair(other.force, other.overlap);
  });
  all.erase(
      std::unique(all.begin(), all.end(),
                  [&](const Crack& one, const Crack& other) { return key(one) == key(other); }),
      all.end());
  return all;
}

}  // namespace trackbed::dem
