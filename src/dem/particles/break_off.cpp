// Pebbles that were overloaded break off their stones, in the order of the numbers of stones and
// pebbles: every rank derives the same shapes and gives the same numbers to fragments, whoever owns
// the stones.
//
// A fragment has the mass of what its stone loses, as a ball of the same density. It begins
// smaller, within the pebble of which it is made and beside what is left of the stone; its mass is
// that of the final size from the begin on, so that the sub-step need not become shorter. Fragments
// lighter than a given mass are removed; their mass is counted as fines. Momentum is kept, and
// angular momentum as seen by an observer who moves with the stone.
//
// Cost: new lists, and for each pebble that a shape loses for the first time an integration of its
// volume and the sieve size of the remainder, on every rank.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

// Of the final radius; a pebble with less space for its fragment becomes fines.
constexpr double least_birth_size = 0.1;

// m, gap between a ball and the nearest of others; below 0: they overlap.
double gap(const Vec3& at, double radius, const std::vector<geom::Sphere>& others) {
  double least = std::numeric_limits<double>::infinity();
  for (const geom::Sphere& other : others)
    least = std::min(least, (at - other.centre).norm() - other.radius - radius);
  return least;
}

constexpr int halvings = 50;  // to the last bits

// The largest ball up to the wanted radius that lies within the pebble, less the overlap of its
// deepest contact, and beside the rest of the stone: it touches the pebble from within in the
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

void forget_piece(std::vector<std::int64_t>& now, std::size_t piece) {
  for (std::int64_t& k : now) {
    if (k == static_cast<std::int64_t>(piece))
      k = -1;
    else if (k > static_cast<std::int64_t>(piece))
      --k;
  }
}

// Histories with new numbers of pieces, without those of lost ones.
void renumber(const std::unordered_map<Id, Changed>& stones, std::vector<History>& histories) {
  constexpr std::int64_t piece_mask = (std::int64_t{1} << piece_bits) - 1;
  const auto renumbered = [&](std::int64_t& key) {
    if (key < 0) return true;
    const auto found = stones.find(particle_of(key));
    if (found == stones.end() || found->second.pieces.empty()) return true;
    const std::int64_t piece = found->second.pieces[static_cast<std::size_t>(key & piece_mask)];
    if (piece < 0) return false;
    key = piece_key(particle_of(key), static_cast<std::size_t>(piece));
    return true;
  };
  std::erase_if(histories,
                [&](History& h) { return !renumbered(h.first) || !renumbered(h.second); });
}

}  // namespace

// Every rank has all shapes and derives the same ones in the same order.
const Loss& Particles::Impl::loss_of(std::int64_t shape, std::size_t piece) {
  const auto known = breaking.losses.find({shape, piece});
  if (known != breaking.losses.end()) return known->second;
  Loss loss;
  loss.rest = geom::without_ball(shapes[shape], piece);
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

// Number of the own particle with this id.
std::optional<std::size_t> Particles::Impl::own_number(Id id) const {
  const auto end = state.id.begin() + static_cast<std::ptrdiff_t>(state.own);
  const auto at = std::lower_bound(state.id.begin(), end, id);
  if (at == end || *at != id) return {};
  return static_cast<std::size_t>(at - state.id.begin());
}

// Of a pebble, by its number in the whole stone, among the pieces that a shape still has.
std::optional<std::size_t> Particles::Impl::piece_of(std::int64_t shape,
                                                     std::int64_t pebble) const {
  for (std::size_t k = shapes.begin(shape); k < shapes.end(shape); ++k)
    if (shapes.label(k) == pebble) return k - shapes.begin(shape);
  return {};
}

// m, of each pebble: the largest overlap of its contacts now, by the owner of the stone, or of the
// contact that broke it. Collective.
std::vector<double> Particles::Impl::depths_of(const std::vector<Crack>& cracks) const {
  std::vector<double> depths(cracks.size());
  std::unordered_map<std::size_t, std::size_t> number;  // of a crack, by piece
  for (std::size_t n = 0; n < cracks.size(); ++n) {
    depths[n] = cracks[n].overlap;
    if (const auto b = own_number(cracks[n].stone))
      if (const auto piece = piece_of(state.shape[*b], cracks[n].pebble))
        number.emplace(pieces.begin[*b] + *piece, n);
  }
  const auto deepen = [&](std::int32_t piece, double overlap) {
    const auto found = number.find(static_cast<std::size_t>(piece));
    if (found != number.end()) depths[found->second] = std::max(depths[found->second], overlap);
  };
  if (!number.empty()) {
    visit_pairs([&](std::int32_t piece, std::int32_t other, const Vec3& d) {
      const double reach =
          pieces.x[static_cast<std::size_t>(piece)].w + pieces.x[static_cast<std::size_t>(other)].w;
      deepen(piece, reach - d.norm()), deepen(other, reach - d.norm());
    });
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
  const std::vector<Crack> cracks = gather_cracks();
  const std::vector<Cut> cuts = gather_cuts();
  breaking.pending = 0;
  if (breaking.ball < 0 && !cracks.empty())
    breaking.ball = shapes.add(
        geom::Template{{geom::ball(Vec3::Zero(), 1)}, ball_volume(1), Vec3::Constant(0.4), 2});
  if (!ready) rebuild();
  const std::vector<double> depths = depths_of(cracks);
  Id last = -1;
  for (std::size_t b = 0; b < state.own; ++b) last = std::max(last, state.id[b]);
  breaking.next = std::max(breaking.next, comm.max(last) + 1);
  std::vector<History> kept = history();
  visit_all(state, [&](auto, auto& array) { array.resize(state.own); });
  std::unordered_map<Id, Changed> stones;
  std::vector<double> lost;  // J
  for (std::size_t n = 0; n < cracks.size(); ++n) {
    Changed& stone =
        stones.try_emplace(cracks[n].stone, Changed{cracks[n].shape, {}}).first->second;
    lost.push_back(break_off(cracks[n], depths[n], stone));
  }
  for (const Cut& cut : cuts) lost.push_back(cut_off(cut, stones));
  comm.sum(std::span<double>(lost));  // at most one term of each is not zero: the sum is exact
  for (const double energy : lost) breaking.totals.lost += energy;
  check_bound();
  renumber(stones, kept), renumber(stones, waiting);
  forget_contacts();
  waiting.insert(waiting.end(), kept.begin(), kept.end());
  population = comm.sum(static_cast<std::int64_t>(state.own));
  ready = false;
}

// One pebble, on every rank; the owner of the stone divides it. Returns the kinetic energy that is
// lost, J, on the owner, else 0.
double Particles::Impl::break_off(const Crack& crack, double depth, Changed& stone) {
  const auto piece = piece_of(stone.shape, crack.pebble);
  const std::size_t count = shapes.end(stone.shape) - shapes.begin(stone.shape);
  if (!piece || count < 2) return 0;
  if (stone.pieces.empty()) {
    stone.pieces.resize(count);
    std::iota(stone.pieces.begin(), stone.pieces.end(), std::int64_t{0});
  }
  const Loss& loss = loss_of(stone.shape, *piece);
  const double radius = radius_of(loss.rest.lost);
  const double mass = crack.density * ball_volume(radius * crack.scale);
  const Birth birth = place_of(loss, depth / crack.scale, breaking.parameters.birth_size * radius);
  const bool fines = mass < breaking.least_mass || birth.radius < least_birth_size * radius;
  const Id fragment = fines ? -1 : breaking.next++;
  double lost = 0;
  if (const auto b = own_number(crack.stone)) {
    const Vec3 where = state.x[*b].vec3() + quat(state.q[*b]) * Vec3(crack.scale * birth.at);
    lost = divide(*b, loss, birth, fragment);
    breaking.breaks.push_back({elapsed, crack.stone, fragment, crack.pebble, where,
                               2 * radius * crack.scale, mass, crack.force, crack.energy, lost, 0,
                               BreakKind::pebble});
  }
  BreakTotals& totals = breaking.totals;
  ++(fines ? totals.fines : totals.fragments);
  (fines ? totals.fines_mass : totals.fragment_mass) += mass;
  totals.released += crack.energy;
  forget_piece(stone.pieces, *piece);
  stone.shape = loss.shape;
  return lost;
}

// Collective.
void Particles::Impl::check_bound() const {
  double largest = 0;
  for (std::size_t b = 0; b < state.own; ++b) largest = std::max(largest, radius(b));
  if (comm.max(largest) > bound)
    throw RunError(
        "a part of a broken stone reaches farther from its centre of mass than the search for "
        "contacts allows; give a lower breakage.threshold or breakage.cutting.largest_depth");
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

}  // namespace trackbed::dem
