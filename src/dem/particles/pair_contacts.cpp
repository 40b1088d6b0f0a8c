// Forces between balls: the law on blocks of eight near pairs (near_pairs.hpp), whose particles are
// loaded as rows and transposed in registers; forces are transposed back and added to the particles
// in the order of the list. All lanes do the same arithmetic, so a contact's result does not depend
// on its lane; lanes that are not in contact add zero. The case of spheres (piece = particle) is
// compiled separately.
//
// Cost per pair of spheres: about 150 flops, 2 roots and 3 divisions for eight at a time, 320 bytes
// of particle data that mostly sits in cache when ids run along the bed, and 80 bytes of the block.
#include <fmt/format.h>

#include <cmath>

#include "dem/lanes/rows.hpp"
#include "dem/particles/impl.hpp"

namespace trackbed::dem {

namespace {

// Arrays of the pair loop, so that the compiler has plain pointers.
struct Arrays {
  const Vec4* piece_x;
  const std::int32_t* body;
  const Vec4* x;
  const Vec4* v;
  const Vec4* w;
  Vec4* f;
  Vec4* t;
};

// Particles of the lanes of a block. Piece and particle have the same number if each particle is
// one sphere, and are then read from the block where they are used.
template <bool spheres>
struct Bodies {
  const PairBlock& block;
  const std::int32_t* body;
  [[gnu::always_inline]] std::size_t i(std::size_t k) const { return of(block.i[k]); }
  [[gnu::always_inline]] std::size_t j(std::size_t k) const { return of(block.j[k]); }

 private:
  [[gnu::always_inline]] std::size_t of(std::int32_t piece) const {
    return static_cast<std::size_t>(spheres ? piece : body[piece]);
  }
};

// The laws of a block's pairs: one for all, or looked up for each.
struct BlockLaws {
  const LawTable& laws;
  Springs<Lanes> springs;
  Rolling<Lanes> rolling;

  explicit BlockLaws(const LawTable& table) : laws(table), springs{}, rolling{} {}
  void set_all(std::uint8_t law) {
    const std::uint8_t same[lanes] = {law, law, law, law, law, law, law, law};
    set(same);
  }
  void set(const std::uint8_t (&law)[lanes]) {
    LawLanes all;
    RollingLanes roll;
    for (std::size_t k = 0; k < lanes; ++k)
      all.set(k, laws[law[k]]), roll.set(k, laws[law[k]].rolling);
    springs = all.get(), rolling = roll.get();
  }
};

// Force on i (on j the opposite) and torques: on i of it, on j of the opposite with changed sign.
struct BlockForce {
  Lanes3 force, turn_i, turn_j;
  Mask beyond;  // overlaps larger than allowed
  Dissipation<Lanes> spent;
};

// The law on all lanes.
//   n = d/|d| from i to j,  delta = r_i + r_j - |d|,
//   arms from piece centres to the middle of the overlap: (r_i - delta/2) n, -(r_j - delta/2) n,
//   v = v_i + w_i x arm_i - v_j - w_j x arm_j,  torques arm x force.
// In v the arms are those of half a step before, like the velocities: the stretch of friction is
// integrated from step to step. With those of the step itself spinning elastic spheres gain energy.
// Both arms end in the same point, so angular momentum is kept to rounding. The contact plane
// rotates about n with the mean of both spins, so that neither particle is preferred. Coincident
// centres have no normal; none is assumed, and the overlap ends the run. The partner is brought to
// the image beside i by its shift; raw positions are subtracted first and the shift is added to the
// difference, in this order on every rank. A distance that is not a number gives no contact.
template <bool spheres, bool hertz, bool rolls, bool accounts>
[[gnu::always_inline]] inline BlockForce respond(const Arrays& a, const NearPairs& near,
                                                 const BlockLaws& laws, const Bodies<spheres>& at,
                                                 PairBlock& b, Lanes* size, Lanes3* rolled,
                                                 double dt, double allowed, const Lanes* limit) {
  const Vec4 *px = a.piece_x, *shifts = near.shifts.data();
  const Lanes3 d = rows_of([&](std::size_t k) {
                     return four(px[b.j[k]]) - four(px[b.i[k]]) + four(shifts[b.shift[k]]);
                   }).xyz();
  const Lanes3 velocity =
      rows_of([&](std::size_t k) { return four(a.v[at.i(k)]) - four(a.v[at.j(k)]); }).xyz();
  const Lanes3 wi = rows(a.w, [&](std::size_t k) { return at.i(k); }).xyz();
  const Lanes3 wj = rows(a.w, [&](std::size_t k) { return at.j(k); }).xyz();
  const Lanes squared = dot(d, d), reach = b.ri + b.rj;
  const Mask touches = squared < reach * reach;
  const Lanes distance = root(squared);
  const Lanes inverse = 1.0 / larger(distance, all(1e-300));
  const Lanes3 n = inverse * d;
  const Lanes delta = reach - distance;
  const Lanes ci = b.ri - 0.5 * delta, cj = 0.5 * delta - b.rj;
  // From the centres of mass to those of the pieces; zero for a sphere.
  Lanes3 to_i{}, to_j{};
  if constexpr (!spheres) {
    to_i = rows_of([&](std::size_t k) { return four(px[b.i[k]]) - four(a.x[at.i(k)]); }).xyz();
    to_j = rows_of([&](std::size_t k) { return four(px[b.j[k]]) - four(a.x[at.j(k)]); }).xyz();
  }
  Lanes3 u = velocity;  // of the centres of the pieces
  if constexpr (!spheres) u = u + (cross(wi, to_i) - cross(wj, to_j));
  Lanes3 v = u + cross(ci * wi - cj * wj, n);
  const Lanes radius = hertz || rolls ? b.ri * b.rj / reach : Lanes{};
  const auto c = coefficients<hertz>(laws.springs, delta, b.root_mass, radius);
  const Lanes rate = dot(v, n);
  const Lanes turning = (0.5 * dt * dt) * inverse * larger(dot(u, u) - rate * rate, Lanes{});
  v = v + (0.25 * dt) * rate * cross(wi + wj, n);
  const Touch<Lanes> touch{n, v, delta, 0.5 * dot(wi + wj, n)};
  const NormalSpring<Lanes> spring =
      spring_force<hertz>(laws.springs, c, OverlapMotion<Lanes>{delta, rate, turning},
                          end_mass(b.root_mass * b.root_mass), radius, dt);
  const Lanes softer = hertz ? softening(*size, c.size) : all(1);
  const auto contact = contact_force(c, touch, spring, softer, dt, b.xi);
  const Lanes3 none{};
  const Lanes3 force = select(touches, contact.friction - contact.normal * n, none);
  // Torques are masked as well: a lost partner's arm is not a number, nor is its product with zero.
  // About the centre of a piece only friction has a moment.
  const Lanes3 moment = cross(n, contact.friction);
  Lanes3 turn_i = ci * moment, turn_j = cj * moment;
  if constexpr (!spheres)
    turn_i = turn_i + cross(to_i, force), turn_j = turn_j + cross(to_j, force);
  BlockForce out{force,
                 select(touches, turn_i, none),
                 select(touches, turn_j, none),
                 touches & (delta > allowed * smaller(b.ri, b.rj)),
                 {}};
  if (limit) out.beyond = out.beyond | (touches & (delta > *limit));
  // A moment of a pair: opposite on j; the sign is applied where torques are added.
  if constexpr (rolls) {
    const Rolls<Lanes> t{n,     wi - wj, touch.twist, contact.normal, contact.next,
                         c.k_n, radius,  b.root_mass};
    const auto resistance = rolling_moment(laws.rolling, t, softer, dt, *rolled);
    const Lanes3 against = select(touches, resistance.moment, none);
    out.turn_i = out.turn_i + against, out.turn_j = out.turn_j + against;
    *rolled = select(touches, *rolled, none);
    if constexpr (accounts) out.spent = resistance.spent;
  }
  if constexpr (accounts) {
    out.spent = out.spent + contact.spent;
    out.spent.friction = select(touches, out.spent.friction, Lanes{});
    out.spent.damping = select(touches, out.spent.damping, Lanes{});
  }
  // A contact that opens loses its springs at once: a stone that touches again has no history, on
  // any rank and after any rebuild.
  b.xi = select(touches, b.xi, none), b.touches = touches;
  if constexpr (hertz) *size = select(touches, c.size, Lanes{});
  return out;
}

// Adds forces in the order of the list, one pair after the other: neighbours in the list share
// particles, so lanes must not add at once. Ghosts collect forces that their owners compute as
// well; these are dropped. `accounts`: the fourth numbers are what is dissipated, which both
// particles get.
template <bool spheres, bool accounts>
[[gnu::always_inline]] inline void add(const Arrays& a, const Bodies<spheres>& at,
                                       const BlockForce& b) {
  Four force[lanes], turn_i[lanes], turn_j[lanes];
  const auto to = [](const Lanes3& v, Lanes fourth, Four* row) {
    to_rows({v.x, v.y, v.z, fourth}, [&](std::size_t k, Four value) { row[k] = value; });
  };
  const Lanes none{};
  to(b.force, accounts ? b.spent.damping : none, force);
  to(b.turn_i, accounts ? b.spent.friction : none, turn_i);
  to(b.turn_j, accounts ? -b.spent.friction : none, turn_j);
  constexpr Four opposite = {-1, -1, -1, 1};
  for (std::size_t k = 0; k < lanes; ++k) {
    const std::size_t i = at.i(k), j = at.j(k);
    put(a.f[i], four(a.f[i]) + force[k]), put(a.t[i], four(a.t[i]) + turn_i[k]);
    put(a.f[j], accounts ? four(a.f[j]) + opposite * force[k] : four(a.f[j]) - force[k]);
    put(a.t[j], four(a.t[j]) - turn_j[k]);
  }
}

// Largest overlap over the smaller radius of a block.
double worst_of(const Arrays& a, const NearPairs& near, const PairBlock& b) {
  double worst = 0;
  for (std::size_t k = 0; k < lanes; ++k) {
    if (b.touches[k] == 0) continue;
    const Vec3 d = a.piece_x[b.j[k]].vec3() - a.piece_x[b.i[k]].vec3() +
                   near.shifts[static_cast<std::size_t>(b.shift[k])].vec3();
    worst = std::max(worst, (b.ri[k] + b.rj[k] - d.norm()) / std::min(b.ri[k], b.rj[k]));
  }
  return worst;
}

// Returns the largest overlap over the smaller radius if it is larger than `allowed`, else 0.
template <bool spheres, bool hertz, bool rolls, bool breaks, bool accounts>
double pair_loop(const Arrays& a, const LawTable& table, NearPairs& near, double dt,
                 double allowed) {
  double worst = 0;
  BlockLaws laws(table);
  if (near.one_law && near.count > 0) laws.set_all(near.blocks[0].law[0]);
  for (std::size_t n = 0; n < near.blocks.size(); ++n) {
    PairBlock& b = near.blocks[n];
    const Bodies<spheres> at{b, a.body};
    if (!near.one_law) laws.set(b.law);
    const BlockForce force = respond<spheres, hertz, rolls, accounts>(
        a, near, laws, at, b, hertz ? &near.size[n] : nullptr, rolls ? &near.roll[n] : nullptr, dt,
        allowed, breaks ? &near.limit[n] : nullptr);
    add<spheres, accounts>(a, at, force);
    if (breaks && any(force.beyond)) near.over.push_back(n);
    if (any(force.beyond)) worst = std::max(worst, worst_of(a, near, b));
  }
  return worst;
}

// The loop compiled for these shapes and laws. If one law is Hertz's, all contacts use the loop
// that computes both; the same holds for rolling. Spheres alone do not break.
template <bool... kinds>
constexpr auto loop_of = pair_loop<kinds...>;
template <bool accounts>
auto loop_for(bool spheres, bool hertz, bool rolls, bool breaks) {
  constexpr decltype(&pair_loop<false, false, false, false, accounts>) loops[] = {
      loop_of<false, false, false, false, accounts>, loop_of<false, false, true, false, accounts>,
      loop_of<false, true, false, false, accounts>,  loop_of<false, true, true, false, accounts>,
      loop_of<true, false, false, false, accounts>,  loop_of<true, false, true, false, accounts>,
      loop_of<true, true, false, false, accounts>,   loop_of<true, true, true, false, accounts>,
      loop_of<false, false, false, true, accounts>,  loop_of<false, false, true, true, accounts>,
      loop_of<false, true, false, true, accounts>,   loop_of<false, true, true, true, accounts>};
  return loops[(breaks ? 8 : 4 * spheres) + 2 * hertz + rolls];
}

}  // namespace

// Reach of near pairs beyond contact, over the skin: the smaller, the fewer pairs are computed and
// the more often they are gathered again. `at_rest`: for beds in which nearly all particles are
// slow, which means that they would not cover that distance within `slow_steps`. The few fast ones
// have all pairs of the list, for as long as it lasts: so a particle that rattles does not
// invalidate the pairs of all others. `moving`: for beds in which more than one particle in `few`
// is fast, and all are treated alike (docs/decisions/particles.md).
constexpr double at_rest = 0.04, moving = 0.1, slow_steps = 100;
constexpr std::size_t few = 16;

// Of any surface point of a particle, m/s.
double Particles::Impl::speed(std::size_t b) const {
  const double turning = shapes.only_spheres() ? 0 : state.x[b].w * state.w[b].vec3().norm();
  return state.v[b].vec3().norm() + turning;
}

// Of all slow particles in this sub-step, own and ghosts, m/s. A value that is not a number ends
// the margin.
double Particles::Impl::fastest_slow() const {
  double fastest = largest_speed;
  for (std::size_t b = state.own; b < state.size(); ++b)
    fastest = not_below(near.slow[b] * speed(b), fastest);
  return fastest;
}

void Particles::Impl::mark_slow_particles(double dt) {
  near.margin = at_rest * skin;
  near.slow.resize(state.size());
  std::size_t fast = 0;
  for (std::size_t b = 0; b < state.size(); ++b) {
    const bool slow = 2 * speed(b) * dt * slow_steps <= near.margin;
    near.slow[b] = slow ? 1 : 0, fast += slow ? 0 : 1;
  }
  if (few * fast <= state.size()) return;
  near.margin = moving * skin;
  std::fill(near.slow.begin(), near.slow.end(), 1);
}

// The paths of slow particles since the last gathering bound the approach of any two; fast ones
// have all their pairs.
bool Particles::Impl::near_pairs_are_due(double dt) {
  if (near_valid) near_path += fastest_slow() * dt;
  return !near_valid || !(2 * near_path <= near.margin);
}

// From the places of all pieces.
void Particles::Impl::gather_near_pairs(double dt) {
  near_pieces.clear();
  if (pairs.entries.empty()) return near.clear();
  if (near_valid) near.store(pairs);
  mark_slow_particles(dt);
  const NearPairs::Limits limits{breaking.strength, laws};
  near.gather(shapes.only_spheres() ? state.x : pieces.x, pieces.body, pairs,
              breaking.strength.empty() ? nullptr : &limits);
  near_valid = true, near_path = 0;
  find_near_pieces();
}

// Corners are found from the poses of all stones: of those all pieces are placed.
void Particles::Impl::find_near_pieces() {
  if (shapes.only_spheres() || shapes.any_stones()) return;
  std::vector<char> is_near(pieces.body.size(), 0);
  for (const PairBlock& block : near.blocks)
    for (const auto* of : {block.i, block.j})
      for (std::size_t k = 0; k < lanes; ++k) is_near[static_cast<std::size_t>(of[k])] = 1;
  for (const Approach& a : approaches) is_near[static_cast<std::size_t>(a.piece)] = 1;
  for (std::size_t p = 0; p < is_near.size(); ++p)
    if (is_near[p] != 0) near_pieces.push_back(static_cast<std::int32_t>(p));
}

// The pieces that this sub-step needs: most pebbles of a clump are inside it or touch nothing. What
// breaks off or grows looks for space among all of them.
void Particles::Impl::place_pieces(bool all) {
  if (shapes.only_spheres()) return;
  if (all || shapes.any_stones() || breaking.active || !breaking.growing.empty())
    place(state, shapes, pieces);
  else
    place(state, shapes, near_pieces, pieces);
}

// Histories of near pairs are written to the list, where they are read and carried over to the next
// one.
void Particles::Impl::store_near_pairs() {
  if (near_valid) near.store(pairs);
}

// Local. Forces are computed from zero: balls first, then stones, each in the order of its list, so
// that every particle adds in the same order on any rank; surfaces follow
// (`compute_surface_forces`).
void Particles::Impl::compute_pair_forces(double dt) {
  const bool spheres = shapes.only_spheres();
  // Those of own spheres have been zero since their kick.
  const auto first = static_cast<std::ptrdiff_t>(spheres ? state.own : 0);
  std::fill(state.f.begin() + first, state.f.end(), Vec4{});
  std::fill(state.t.begin() + first, state.t.end(), Vec4{});
  const bool due = near_pairs_are_due(dt);
  place_pieces(due);
  if (due) gather_near_pairs(dt);
  const Arrays a{spheres ? state.x.data() : pieces.x.data(),
                 pieces.body.data(),
                 state.x.data(),
                 state.v.data(),
                 state.w.data(),
                 state.f.data(),
                 state.t.data()};
  const bool breaks = !near.limit.empty();
  near.over.clear();
  const auto loop = parameters.energy_balance
                        ? loop_for<true>(spheres, laws.any_hertz(), laws.any_rolls(), breaks)
                        : loop_for<false>(spheres, laws.any_hertz(), laws.any_rolls(), breaks);
  double worst = loop(a, laws, near, dt, parameters.largest_overlap);
  watch_near_pairs();
  if (shapes.any_stones())
    worst = std::max(worst, stone_contacts.compute_forces(scene(), dt, stones, state));
  if (worst > parameters.largest_overlap)
    report(fmt::format(
        "two stones overlap by {:.3g} times the smaller radius (of stones with corners: the "
        "smaller rounding radius), more than dem.largest_overlap = {:.3g}; use a smaller time.step "
        "or dem.safety, stiffer contacts, or slower loading{}",
        worst, parameters.largest_overlap, softness()));
}

}  // namespace trackbed::dem
