// Breakage of the corners of clumps (Chen et al. 2023, doi:10.1016/j.compgeo.2022.105105).
//
// A pebble is overloaded if the normal spring of one of its contacts has more force than the pebble
// has strength. The pair loop compares overlaps, which it has anyway, with the overlap at that
// force, so that nothing is added to its work. Overloaded pebbles of all ranks break off together
// at the begin of the next window, in the order of the numbers of stones and pebbles: every rank
// derives the same shapes and gives the same numbers to fragments, whoever owns the stones.
//
// A fragment has the mass of what its stone loses, as a ball of the same density. It begins
// smaller, within the pebble of which it is made and beside what is left of the stone, and grows to
// its size within some sub-steps; its mass is that of the final size from the begin on, so that the
// sub-step need not become shorter. Fragments lighter than a given mass are removed; their mass is
// counted as fines. Momentum is kept, and angular momentum as seen by an observer who moves with
// the stone.
//
// Cost when nothing breaks: a limit of eight numbers for each block of pairs (near_pairs.hpp).
// When something does: new lists, and for each pebble that a shape loses for the first time an
// integration of its volume (about a millisecond) on every rank.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/dem/templates.hpp"

namespace trackbed::dem {

namespace {

// Of the final radius; a pebble with less space for its fragment becomes fines.
constexpr double least_birth_size = 0.1;

double ball_volume(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }
double radius_of(double volume) { return std::cbrt(3 * volume / (4 * std::numbers::pi)); }

// m, gap between a ball and the nearest of others; below 0: they overlap.
double gap(const Vec3& at, double radius, const std::vector<geom::Sphere>& others) {
  double least = std::numeric_limits<double>::infinity();
  for (const geom::Sphere& other : others)
    least = std::min(least, (at - other.centre).norm() - other.radius - radius);
  return least;
}

// Of the largest radius when stones begin to break: a clump of which every corner on one side
// breaks off has its centre of mass moved by less than this.
constexpr double remainder_room = 1.5;

constexpr int halvings = 50;  // to the last bits

// Growths within `growth_steps`, and the longest one over the radius of the smallest fragment.
constexpr std::int64_t growths = 5;
constexpr double longest_growth = 0.1;

// The largest ball up to the wanted radius that lies within the pebble, less the overlap of the
// contact that broke it, and beside the rest of the stone: it touches the pebble from within in the
// direction of the lost part, so that smaller balls are inside larger ones and bisection finds it.
// Then it is moved towards the stone until both touch.
Birth place_of(const Loss& loss, double overlap, double wanted) {
  const double reach = loss.pebble.radius - overlap;
  const auto at = [&](double radius) -> Vec3 {
    return loss.pebble.centre + (reach - radius) * loss.out;
  };
  const auto fits = [&](double radius) { return gap(at(radius), radius, loss.beside) >= 0; };
  double low = 0, high = std::min(wanted, reach);
  if (!fits(high))
    for (int k = 0; k < halvings; ++k) {
      const double middle = (low + high) / 2;
      (fits(middle) ? low : high) = middle;
    }
  else
    low = high;
  double beside = 0, within = 2 * (reach - low);  // m, inwards; the ball stays within the pebble
  if (low > 0 && gap(at(low) - within * loss.out, low, loss.beside) < 0)
    for (int k = 0; k < halvings; ++k) {
      const double middle = (beside + within) / 2;
      (gap(at(low) - middle * loss.out, low, loss.beside) >= 0 ? beside : within) = middle;
    }
  else
    beside = within;
  return {at(low) - beside * loss.out, low};
}

// What becomes of the numbers of a stone's pieces.
using Renumbered = std::unordered_map<Id, std::vector<std::int64_t>>;

void forget_piece(std::vector<std::int64_t>& now, std::size_t piece) {
  for (std::int64_t& k : now) {
    if (k == static_cast<std::int64_t>(piece))
      k = -1;
    else if (k > static_cast<std::int64_t>(piece))
      --k;
  }
}

// Histories with new numbers of pieces, without those of lost ones.
void renumber(const Renumbered& stones, std::vector<History>& histories) {
  constexpr std::int64_t piece_mask = (std::int64_t{1} << piece_bits) - 1;
  const auto renumbered = [&](std::int64_t& key) {
    if (key < 0) return true;
    const auto found = stones.find(particle_of(key));
    if (found == stones.end()) return true;
    const std::int64_t piece = found->second[static_cast<std::size_t>(key & piece_mask)];
    if (piece < 0) return false;
    key = piece_key(particle_of(key), static_cast<std::size_t>(piece));
    return true;
  };
  std::erase_if(histories,
                [&](History& h) { return !renumbered(h.first) || !renumbered(h.second); });
}

}  // namespace

double strength_of(const BreakageParameters& p, Id stone, std::int64_t pebble, double diameter) {
  const auto key = static_cast<std::uint64_t>(piece_key(stone, static_cast<std::size_t>(pebble)));
  const double drawn = uniform(static_cast<std::uint64_t>(p.seed), key);
  const double survival = std::clamp(drawn, 0x1.0p-54, 1 - 0x1.0p-53);  // above 0 and below 1
  return p.strength * diameter * diameter * std::pow(diameter / p.diameter, p.size_exponent) *
         std::pow(-std::log(survival), 1 / p.weibull);
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
  if (!active) r.breaking.cracks.clear(), r.breaking.pending = 0;
  if (active == r.breaking.active) return;
  if (active && r.shapes.any_stones())
    throw RunError(
        "there are stones with corners, but only pebbles of clumps break off: give "
        "breakage.strength = 0, or clumps");
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
  // Lists need strengths, cells the largest radius.
  const std::vector<double> work = r.work();  // while lists still exist
  const std::vector<History> kept = r.history();
  visit_state(r.state, [&](auto, auto& array) { array.resize(r.state.own); });
  r.forget_contacts();
  r.waiting.insert(r.waiting.end(), kept.begin(), kept.end());
  r.choose_grid(work);
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
  if (!impl_->breaking.active) return -1;
  std::int64_t count = 0;
  for (std::size_t b = 0; b < size(); ++b) impl_->visit_weak(b, [&](std::size_t) { ++count; });
  return impl_->comm.sum(count);
}

void Particles::Impl::watch(std::size_t piece, const Law& law, double force, double overlap) {
  const auto b = static_cast<std::size_t>(pieces.body[piece]);
  if (b >= state.own || !(force > breaking.strength[piece])) return;
  const std::size_t k = shapes.begin(state.shape[b]) + piece - pieces.begin[b];
  const double density = physics.materials[static_cast<std::size_t>(state.material[b])].density;
  const double energy = (law.springs.hertz > 0 ? 0.4 : 0.5) * force * overlap;
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
      const double reach = block.ri[k] + block.rj[k];
      const Vec3 d = pieces.x[j].vec3() - pieces.x[i].vec3() +
                     near.shifts[static_cast<std::size_t>(block.shift[k])].vec3();
      const double overlap = reach - d.norm();
      const Law& law = laws[block.law[k]];
      const double force =
          coefficients<true>(law.springs, overlap, 0.0, block.ri[k] * block.rj[k] / reach).k_n *
          overlap;
      watch(i, law, force, overlap), watch(j, law, force, overlap);
    }
  }
  near.over.clear();
}

// Of stones that are removed. Collective.
void Particles::Impl::forget_cracks(const std::vector<Id>& gone) {
  if (breaking.pending == 0) return;
  std::erase_if(breaking.cracks, [&](const Crack& crack) {
    return std::binary_search(gone.begin(), gone.end(), crack.stone);
  });
  breaking.pending = comm.sum(static_cast<std::int64_t>(breaking.cracks.size()));
}

// Of all ranks, each pebble once, by stone and pebble. A stone that changed its owner within the
// window may be reported twice.
std::vector<Crack> Particles::Impl::gather_cracks() {
  std::vector<Crack> all = comm.all_gather(std::span<const Crack>(breaking.cracks));
  breaking.cracks.clear(), breaking.pending = 0;
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

// Every rank has all shapes and derives the same ones in the same order.
const Loss& Particles::Impl::loss_of(std::int64_t shape, std::size_t piece) {
  const auto known = breaking.losses.find({shape, piece});
  if (known != breaking.losses.end()) return known->second;
  Loss loss;
  loss.piece = piece, loss.rest = geom::without_ball(shapes[shape], piece);
  std::vector<std::int64_t> labels;
  const std::vector<Piece>& pieces_of = shapes[shape].pieces;
  for (std::size_t k = 0; k < pieces_of.size(); ++k) {
    const geom::Sphere ball{pieces_of[k].core.vertices[0], pieces_of[k].radius};
    if (k == piece) {
      loss.pebble = ball;
      continue;
    }
    loss.beside.push_back(ball);
    labels.push_back(shapes.label(shapes.begin(shape) + k));
  }
  const Vec3 out = loss.rest.lost_centre - loss.pebble.centre;
  loss.out = (out.norm() > 1e-6 * loss.pebble.radius ? out : loss.pebble.centre).normalized();
  loss.shape = shapes.add(loss.rest.stone, labels);
  return breaking.losses.emplace(std::pair(shape, piece), std::move(loss)).first->second;
}

// m, of each pebble: the largest overlap of its contacts now, by the owner of the stone, or of the
// contact that broke it. Collective.
std::vector<double> Particles::Impl::depths_of(const std::vector<Crack>& cracks) const {
  std::vector<double> depths(cracks.size());
  std::unordered_map<std::size_t, std::size_t> number;  // of a crack, by piece
  for (std::size_t n = 0; n < cracks.size(); ++n) {
    depths[n] = cracks[n].overlap;
    const auto end = state.id.begin() + static_cast<std::ptrdiff_t>(state.own);
    const auto at = std::lower_bound(state.id.begin(), end, cracks[n].stone);
    if (at == end || *at != cracks[n].stone) continue;
    const auto b = static_cast<std::size_t>(at - state.id.begin());
    for (std::size_t p = pieces.begin[b]; p < pieces.begin[b + 1]; ++p)
      if (shapes.label(shapes.begin(state.shape[b]) + p - pieces.begin[b]) == cracks[n].pebble)
        number.emplace(p, n);
  }
  const auto deepen = [&](std::int32_t piece, double overlap) {
    const auto found = number.find(static_cast<std::size_t>(piece));
    if (found != number.end()) depths[found->second] = std::max(depths[found->second], overlap);
  };
  if (!number.empty()) {
    for (const Row& row : pairs.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e) {
        const Entry& entry = pairs.entries[e];
        const Vec4 &i = pieces.x[static_cast<std::size_t>(row.piece)],
                   &j = pieces.x[static_cast<std::size_t>(entry.piece)];
        const Vec3 d = j.vec3() - i.vec3() + pairs.shifts[entry.shift].vec3();
        deepen(row.piece, i.w + j.w - d.norm()), deepen(entry.piece, i.w + j.w - d.norm());
      }
    std::vector<MeshContact> found;
    for (const Approach& a : approaches) {
      if (!number.contains(static_cast<std::size_t>(a.piece))) continue;
      const Vec4& x = pieces.x[static_cast<std::size_t>(a.piece)];
      const auto surface = static_cast<std::size_t>(a.surface);
      found.clear();
      meshes[surface].touch({x.vec3() + a.shift, x.w}, a.triangles, *surfaces[surface], 0, found);
      for (const MeshContact& c : found) deepen(a.piece, x.w - c.distance);
    }
  }
  comm.max(std::span<double>(depths));
  return depths;
}

// Collective; with no cracks on any rank, nothing. Forces at the present time are kept: those of
// lost contacts act once more, equally on both sides, in the first half kick.
void Particles::Impl::break_off() {
  if (breaking.pending == 0) return;
  const std::vector<Crack> all = gather_cracks();
  if (breaking.ball < 0)
    breaking.ball = shapes.add(
        geom::Template{{geom::ball(Vec3::Zero(), 1)}, ball_volume(1), Vec3::Constant(0.4), 2});
  if (!ready) rebuild();
  const std::vector<double> depths = depths_of(all);
  Id last = -1;
  for (std::size_t b = 0; b < state.own; ++b) last = std::max(last, state.id[b]);
  breaking.next = std::max(breaking.next, comm.max(last) + 1);
  std::vector<History> kept = history();
  visit_state(state, [&](auto, auto& array) { array.resize(state.own); });
  state.w.resize(state.own), state.inertia.resize(state.own);
  Renumbered stones;
  std::unordered_map<Id, std::int64_t> shape_now;
  std::vector<double> lost(all.size(), 0);  // J
  for (std::size_t n = 0; n < all.size(); ++n) {
    const Crack& crack = all[n];
    std::int64_t& shape = shape_now.try_emplace(crack.stone, crack.shape).first->second;
    const std::size_t begin = shapes.begin(shape), count = shapes.end(shape) - begin;
    std::vector<std::int64_t>& now = stones[crack.stone];
    for (std::size_t k = now.size(); k < count && shape == crack.shape; ++k)
      now.push_back(static_cast<std::int64_t>(k));
    std::size_t piece = 0;
    while (piece < count && shapes.label(begin + piece) != crack.pebble) ++piece;
    if (piece == count || count < 2) continue;
    const Loss& loss = loss_of(shape, piece);
    const double radius = radius_of(loss.rest.lost);
    const double mass = crack.density * ball_volume(radius * crack.scale);
    const Birth birth =
        place_of(loss, depths[n] / crack.scale, breaking.parameters.birth_size * radius);
    const bool fines = mass < breaking.least_mass || birth.radius < least_birth_size * radius;
    const Id fragment = fines ? -1 : breaking.next++;
    const auto own_end = state.id.begin() + static_cast<std::ptrdiff_t>(state.own);
    const auto at = std::lower_bound(state.id.begin(), own_end, crack.stone);
    if (at != own_end && *at == crack.stone) {
      const auto b = static_cast<std::size_t>(at - state.id.begin());
      const Vec3 where = state.x[b].vec3() + quat(state.q[b]) * Vec3(crack.scale * birth.at);
      lost[n] = divide(b, loss, birth, fragment);
      breaking.breaks.push_back({breaking.elapsed, crack.stone, fragment, crack.pebble, where,
                                 2 * radius * crack.scale, mass, crack.force, crack.energy,
                                 lost[n]});
    }
    BreakTotals& totals = breaking.totals;
    ++(fines ? totals.fines : totals.fragments);
    (fines ? totals.fines_mass : totals.fragment_mass) += mass;
    totals.released += crack.energy;
    forget_piece(now, piece);
    shape = loss.shape;
  }
  double largest = 0;
  for (std::size_t b = 0; b < state.own; ++b) largest = std::max(largest, radius(b));
  if (comm.max(largest) > bound)
    throw RunError(
        "a stone that lost corners reaches farther from its centre of mass than the search for "
        "contacts allows; give a lower breakage.threshold");
  comm.sum(std::span<double>(lost));  // one term of each is not zero, so the sum is exact
  for (const double energy : lost) breaking.totals.lost += energy;
  renumber(stones, kept), renumber(stones, waiting);
  forget_contacts();
  waiting.insert(waiting.end(), kept.begin(), kept.end());
  population = comm.sum(static_cast<std::int64_t>(state.own));
  ready = false;
}

// Stone b becomes its remainder and a fragment, if that has a number. With the arms d from the
// centre of mass of the whole and its spin w, the parts have the velocities v + w x d of their
// centres, by which momentum is kept. The fragment is not where its mass was: the spin of the
// remainder takes up the difference of angular momentum, so that energy may also be gained. Fines
// take their momentum and energy with them. Returns the kinetic energy that is lost, J.
double Particles::Impl::divide(std::size_t b, const Loss& loss, const Birth& birth, Id fragment) {
  const double scale = state.scale[b], whole = mass(b);
  const Quat q = quat(state.q[b]);
  const Vec3 x = state.x[b].vec3(), v = state.v[b].vec3(), momentum = state.l[b].vec3();
  const Vec3 body = q.conjugate() * momentum;
  const Vec3 spin = q * Vec3(body.cwiseQuotient(state.inertia[b].vec3()));
  double energy = 0.5 * whole * v.squaredNorm() + 0.5 * momentum.dot(spin);
  const Vec3 to_rest = q * Vec3(scale * loss.rest.centre);
  const Vec3 to_lost = q * Vec3(scale * loss.rest.lost_centre);
  const double density = physics.materials[static_cast<std::size_t>(state.material[b])].density;
  const double radius = radius_of(loss.rest.lost) * scale;
  const double lost_mass = density * ball_volume(radius);
  const Vec3 away = spin.cross(to_lost);  // m/s, relative to v
  Vec3 rest_momentum = momentum - (whole - lost_mass) * to_rest.cross(spin.cross(to_rest));
  if (fragment >= 0) {
    const double now = birth.radius * scale;
    const Vec3 to_fragment = q * Vec3(scale * birth.at);
    const Vec3 turning = 0.4 * lost_mass * now * now * spin;
    rest_momentum -= lost_mass * to_fragment.cross(away) + turning;
    add_fragment(b, fragment, radius, now / radius);
    state.x.back().set(x + to_fragment), state.v.back().set(v + away);
    state.l.back().set(turning);
    energy -= 0.5 * lost_mass * (v + away).squaredNorm() + 0.5 * turning.dot(spin);
  } else {
    rest_momentum -= lost_mass * to_lost.cross(away);
  }
  state.shape[b] = loss.shape;
  state.x[b].set(x + to_rest);
  state.q[b] = vec4((q * loss.rest.axes).normalized());
  state.v[b].set(v + spin.cross(to_rest));
  state.l[b].set(rest_momentum);
  state.t[b].set(state.t[b].vec3() - to_rest.cross(state.f[b].vec3()));
  derive_one(b);
  if (fragment >= 0) derive_one(state.own - 1);
  return energy - 0.5 * mass(b) * state.v[b].vec3().squaredNorm() -
         0.5 * rest_momentum.dot(state.w[b].vec3());
}

// Behind all own particles; its pose and motion are set by the caller.
void Particles::Impl::add_fragment(std::size_t b, Id id, double scale, double part) {
  const std::int64_t material = state.material[b];
  visit_all(state, [](auto, auto& array) { array.emplace_back(); });
  state.id.back() = id, state.shape.back() = breaking.ball, state.material.back() = material;
  state.scale.back() = scale, state.q.back() = vec4(Quat::Identity());
  state.part.back() = part;
  state.own = state.size();
}

// One pass over the lists.
void Particles::Impl::find_growing() {
  breaking.growing.clear();
  breaking.grown_since_rebuild = breaking.next_growth = 0;
  if (breaking.totals.fragments == 0) return;           // the same on all ranks
  std::unordered_map<std::size_t, std::size_t> number;  // of own bodies, in `growing`
  for (std::size_t b = 0; b < state.size(); ++b) {
    if (!state.is_fragment(b) || state.part[b] >= 1) continue;
    if (b < state.own) number.emplace(b, breaking.growing.size());
    breaking.growing.push_back({b, state.x[b].w, {}, {}});
  }
  // The same on all ranks.
  if (comm.max(static_cast<std::int64_t>(breaking.growing.size())) > 0)
    breaking.next_growth = longest_growth * breaking.least_radius;
  if (number.empty()) return;
  const auto of = [&](std::int32_t piece) -> GrowingFragment* {
    const auto found =
        number.find(static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]));
    return found == number.end() ? nullptr : &breaking.growing[found->second];
  };
  for (const Row& row : pairs.rows)
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const Entry& entry = pairs.entries[e];
      const Vec4& shift = pairs.shifts[entry.shift];
      if (GrowingFragment* one = of(row.piece)) one->beside.push_back({entry.piece, shift});
      if (GrowingFragment* other = of(entry.piece))
        other->beside.push_back({row.piece, {-shift.x, -shift.y, -shift.z, 0}});
    }
  for (std::size_t k = 0; k < approaches.size(); ++k)
    if (GrowingFragment* one = of(approaches[k].piece)) one->approaches.push_back(k);
}

// m, by how much the radius may grow, up to the wanted length: no contact is then compressed by
// more than the allowed part of the final radius. Partners that are not in the lists are farther
// away than a fragment grows in a window (`lists_are_old`).
double Particles::Impl::space_of(const GrowingFragment& fragment, double wanted) const {
  const std::size_t b = fragment.body, p = pieces.begin[b];
  const double allowed = breaking.parameters.growth_overlap * state.scale[b];
  const Vec3 at = pieces.x[p].vec3();
  const double radius = pieces.x[p].w;
  double space = wanted;
  for (const GrowingFragment::Neighbour& other : fragment.beside) {
    const Vec4& x = pieces.x[static_cast<std::size_t>(other.piece)];
    const double gap = (x.vec3() + other.shift.vec3() - at).norm() - radius - x.w;
    // Another one that grows takes the other half.
    const auto body = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(other.piece)]);
    const bool grows = state.is_fragment(body) && state.part[body] < 1;
    space = std::min(space, grows ? (gap + allowed) / 2 : gap + allowed);
  }
  std::vector<MeshContact> found;
  for (const std::size_t k : fragment.approaches) {
    const Approach& a = approaches[k];
    const auto surface = static_cast<std::size_t>(a.surface);
    found.clear();
    meshes[surface].touch({at + a.shift, radius + wanted}, a.triangles, *surfaces[surface], 0,
                          found);
    for (const MeshContact& c : found) space = std::min(space, c.distance - radius + allowed);
  }
  return std::max(space, 0.0);
}

void Particles::Impl::set_part(std::size_t b, double part) {
  state.part[b] = part;
  derive_size(b);
  if (b < state.own) update_spin(b);
  for (std::size_t p = pieces.begin[b]; p < pieces.begin[b + 1]; ++p)
    pieces.x[p].w = shapes.piece(shapes.begin(state.shape[b])).w * state.scale_now(b);
}

namespace {

struct Grown {
  std::int64_t id;
  double part;
};

}  // namespace

// Every few sub-steps, as near pairs are gathered again after each growth. Owners decide and send
// the sizes in one small message.
void Particles::Impl::grow_fragments(int steps_of_window) {
  if (breaking.next_growth == 0) return;  // the same on all ranks
  const BreakageParameters& p = breaking.parameters;
  const std::int64_t every = std::max<std::int64_t>(p.growth_steps / growths, 1);
  if (steps % every >= steps_of_window) return;
  const double passed = static_cast<double>(std::max<std::int64_t>(every, steps_of_window));
  const double part = 0.5 * passed / static_cast<double>(p.growth_steps);
  std::vector<Grown> grown;
  for (const GrowingFragment& fragment : breaking.growing) {
    const std::size_t b = fragment.body;
    if (b >= state.own) continue;
    const double left = (1 - state.part[b]) * state.scale[b];
    const double wanted = std::min({part * state.scale[b], breaking.next_growth, left});
    // Pieces are where they were in the last sub-step or at the rebuild, that is, where they are.
    const double space = space_of(fragment, wanted);
    if (space >= std::min(wanted, 0.5 * p.growth_overlap * state.scale[b]))
      grown.push_back({state.id[b], std::min(1.0, state.part[b] + space / state.scale[b])});
  }
  grown = comm.all_gather(std::span<const Grown>(grown));
  if (grown.empty()) return;
  store_near_pairs(), near_valid = false;
  std::unordered_map<Id, double> parts;
  for (const Grown& g : grown) parts.emplace(g.id, g.part);
  for (const GrowingFragment& fragment : breaking.growing) {
    const auto found = parts.find(state.id[fragment.body]);
    if (found == parts.end()) continue;
    set_part(fragment.body, found->second);
    breaking.grown_since_rebuild =
        std::max(breaking.grown_since_rebuild, state.x[fragment.body].w - fragment.radius);
  }
  std::erase_if(breaking.growing,
                [&](const GrowingFragment& fragment) { return state.part[fragment.body] >= 1; });
}

namespace {

constexpr int crack_columns = sizeof(Crack) / sizeof(double);
constexpr int break_columns = 12;

}  // namespace

void Particles::Impl::save_breakage(io::File& file, const std::string& group) const {
  const Breaking& b = breaking;
  if (b.parameters.strength == 0 && b.ball < 0) return;
  const std::string at = group + "/breakage";
  std::vector<std::int64_t> labels;
  if (comm.root()) labels = shapes.labels();
  file.write<std::int64_t>(at + "/labels", labels, 1,
                           {"-", "of each piece of the templates: its number in the whole stone"});
  std::vector<double> cracks, breaks;
  for (const Crack& c : b.cracks)
    cracks.insert(cracks.end(),
                  {static_cast<double>(c.stone), static_cast<double>(c.pebble),
                   static_cast<double>(c.shape), c.scale, c.density, c.force, c.overlap, c.energy});
  for (const Break& e : b.breaks)
    breaks.insert(breaks.end(),
                  {e.time, static_cast<double>(e.stone), static_cast<double>(e.fragment),
                   static_cast<double>(e.pebble), e.position.x(), e.position.y(), e.position.z(),
                   e.diameter, e.mass, e.force, e.released, e.lost});
  file.write<double>(at + "/cracks", cracks, crack_columns,
                     {"-, -, -, -, kg/m3, N, m, J",
                      "pebbles that break off in the next window: stone, pebble, template, scale, "
                      "density, force, overlap, energy"});
  file.write<double>(
      at + "/breaks", breaks, break_columns,
      {"s, -, -, -, m, m, m, m, kg, N, J, J",
       "pebbles that broke off: time, stone, fragment (-1: fines), pebble, x, y, z, "
       "diameter, mass, force, elastic energy of this contact, kinetic energy lost"});
  file.attribute(group, "breaking", static_cast<std::int64_t>(b.active));
  file.attribute(group, "break_ball", static_cast<std::int64_t>(b.ball));
  file.attribute(group, "break_next", b.next);
  file.attribute(group, "break_pending", b.pending);
  file.attribute(group, "break_least_mass", b.least_mass);
  file.attribute(group, "break_least_radius", b.least_radius);
  file.attribute(group, "break_largest_radius", b.largest_radius);
  file.attribute(group, "break_elapsed", b.elapsed);
  file.attribute(group, "break_fragments", b.totals.fragments);
  file.attribute(group, "break_fines", b.totals.fines);
  file.attribute(group, "break_fragment_mass", b.totals.fragment_mass);
  file.attribute(group, "break_fines_mass", b.totals.fines_mass);
  file.attribute(group, "break_released", b.totals.released);
  file.attribute(group, "break_lost", b.totals.lost);
}

void Particles::Impl::load_shapes(const io::File& file, const std::string& group) {
  const std::string path = group + "/breakage/labels";
  std::vector<std::int64_t> labels;
  if (file.has(path)) labels = file.read_all<std::int64_t>(path);
  std::size_t first = 0;
  for (const Template& shape : load_templates(file, group + "/template")) {
    const std::size_t end = first + shape.pieces.size();
    const auto at = [&](std::size_t k) { return labels.begin() + static_cast<std::ptrdiff_t>(k); };
    if (end <= labels.size())
      shapes.add(shape, {at(first), at(end)});
    else
      shapes.add(shape);
    first = end;
  }
}

// A state without breakage begins it with its next stage.
void Particles::Impl::load_breakage(const io::File& file, const std::string& group) {
  Breaking& b = breaking;
  const BreakageParameters parameters = b.parameters;
  const int material = b.material;
  b = {};
  b.parameters = parameters, b.material = material;
  const std::string at = group + "/breakage";
  if (!file.has(at + "/cracks")) return;
  const auto whole = [](double value) { return std::llround(value); };
  const auto cracks = file.read_own_rows<double>(at + "/cracks");
  for (std::size_t k = 0; k + crack_columns <= cracks.size(); k += crack_columns) {
    const double* c = cracks.data() + k;
    b.cracks.push_back({whole(c[0]), whole(c[1]), whole(c[2]), c[3], c[4], c[5], c[6], c[7]});
  }
  const auto breaks = file.read_own_rows<double>(at + "/breaks");
  for (std::size_t k = 0; k + break_columns <= breaks.size(); k += break_columns) {
    const double* e = breaks.data() + k;
    b.breaks.push_back({e[0], whole(e[1]), whole(e[2]), whole(e[3]), Vec3(e[4], e[5], e[6]), e[7],
                        e[8], e[9], e[10], e[11]});
  }
  b.active = file.integer_attribute(group, "breaking") != 0;
  b.ball = static_cast<int>(file.integer_attribute(group, "break_ball"));
  b.next = file.integer_attribute(group, "break_next");
  b.pending = file.integer_attribute(group, "break_pending");
  b.least_mass = file.number_attribute(group, "break_least_mass");
  b.least_radius = file.number_attribute(group, "break_least_radius");
  b.largest_radius = file.number_attribute(group, "break_largest_radius");
  b.elapsed = file.number_attribute(group, "break_elapsed");
  b.totals = {file.integer_attribute(group, "break_fragments"),
              file.integer_attribute(group, "break_fines"),
              file.number_attribute(group, "break_fragment_mass"),
              file.number_attribute(group, "break_fines_mass"),
              file.number_attribute(group, "break_released"),
              file.number_attribute(group, "break_lost")};
}

}  // namespace trackbed::dem
