// Forces of pieces on pieces, in three passes: which entries touch (cheap, most do not); eight
// touching contacts at a time through the law (vectorised: all lanes do the same arithmetic, so a
// contact's bits do not depend on its lane); the forces added to the particles in the order of the
// list. The sphere's case (piece = particle) is compiled apart.
//
// Cost per touching contact of spheres: about 150 flops with 2 roots and 3 divisions, and 0.5 kB of
// particle data that mostly sits in cache when ids run along the bed.
#include <fmt/format.h>

#include <cmath>

#include "room.hpp"

namespace trackbed::dem {

namespace {

// Eight contacts: what the law reads and what it gives.
// Filled from scattered particles, worked on in lanes, written back: the copy pays because the law
// has two roots and three divisions, which cost the same for eight as for one.
struct alignas(64) Group {
  Lane3 d, vi, vj, wi, wj, ai, aj;        // a: piece centre from the particle's, clumps only
  Lane3 xi, roll, force, turn_i, turn_j;  // turn: torque on the particle, of force and of -force
  double ri[lanes], rj[lanes], root_mass[lanes], size[lanes], overlap[lanes];
  LawLanes law;
  RollingLanes rolling;
};

// Arrays of the pair loop, so that the compiler sees plain pointers.
struct Arrays {
  const Vec4* piece_x;
  const std::int32_t* body;
  const Vec4* x;
  const Vec4* v;
  const Vec4* w;
  Vec4* f;
  Vec4* t;
};

// Marks entries that touch; those that do no more lose their history.
// A contact that opens gives its springs back at once: a stone that comes again meets it without
// history, on whatever rank and after whatever rebuild.
void find_touching(const Vec4* piece_x, PairList& list) {
  list.touching.clear();
  for (const Row& row : list.rows) {
    const Vec4 pi = piece_x[row.piece];
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      Entry& entry = list.entries[e];
      const Vec4& pj = piece_x[entry.piece];
      const Vec4& h = list.shifts[entry.shift];
      const double dx = pj.x - pi.x + h.x, dy = pj.y - pi.y + h.y, dz = pj.z - pi.z + h.z;
      const double reach = pi.w + pj.w;
      // Squares: most entries do not touch and need no root. What is not a number does not touch.
      if (dx * dx + dy * dy + dz * dz < reach * reach) {
        entry.touching = 1;
        list.touching.push_back({e, row.piece});
      } else if (entry.touching) {
        list.forget(e);
      }
    }
  }
}

// Piece and particle have one number if each particle is one sphere.
template <bool spheres>
std::size_t particle(const Arrays& a, std::int32_t piece) {
  return static_cast<std::size_t>(spheres ? piece : a.body[piece]);
}

// Gathers eight contacts. The partner is brought to the image beside i by its shift; raw positions
// are subtracted first and the shift is added to the difference, in this order on every rank.
template <bool spheres, bool hertz, bool rolls>
void load(const Arrays& a, const LawTable& laws, const PairList& list, const Contact* contacts,
          std::size_t count, Group& g) {
  for (std::size_t k = 0; k < lanes; ++k) {
    const Contact& c = contacts[k < count ? k : 0];  // spare lanes repeat a contact, unused
    const Entry& entry = list.entries[c.entry];
    const Vec4 &pi = a.piece_x[c.piece], &pj = a.piece_x[entry.piece],
               &h = list.shifts[entry.shift];
    const std::size_t i = particle<spheres>(a, c.piece), j = particle<spheres>(a, entry.piece);
    g.d.put(k, pj.x - pi.x + h.x, pj.y - pi.y + h.y, pj.z - pi.z + h.z);
    g.ri[k] = pi.w, g.rj[k] = pj.w;
    g.vi.put(k, a.v[i]), g.vj.put(k, a.v[j]);
    g.wi.put(k, a.w[i]), g.wj.put(k, a.w[j]);
    if constexpr (!spheres) {
      g.ai.put(k, pi.x - a.x[i].x, pi.y - a.x[i].y, pi.z - a.x[i].z);
      g.aj.put(k, pj.x - a.x[j].x, pj.y - a.x[j].y, pj.z - a.x[j].z);
    }
    const Vec4& xi = list.xi[c.entry];
    g.xi.put(k, xi), g.root_mass[k] = xi.w;
    g.law.set(k, laws[entry.law]);
    if constexpr (hertz) g.size[k] = list.size[c.entry];
    if constexpr (rolls)
      g.rolling.set(k, laws[entry.law].rolling), g.roll.put(k, list.roll[c.entry]);
  }
}

// The law on all lanes. Everything is inlined into one loop without branches.
//   n = d/|d| from i to j,  delta = r_i + r_j - |d|,
//   arms from piece centres to the middle of the overlap: (r_i - delta/2) n, -(r_j - delta/2) n,
//   v = v_i + w_i x arm_i - v_j - w_j x arm_j,  torques arm x force.
// Both arms end in the same point, so angular momentum is kept to rounding. The contact plane turns
// about n with the mean of both spins: nobody's history is preferred. Centres in one place have no
// normal; none is invented, and the overlap ends the run.
template <bool spheres, bool hertz, bool rolls>
void respond(Group& g, double dt) {
  const Lanes3 d = g.d.get(), wi = g.wi.get(), wj = g.wj.get();
  const Lanes ri = dem::load(g.ri), rj = dem::load(g.rj), root_mass = dem::load(g.root_mass);
  const Lanes distance = root(dot(d, d));
  const Lanes3 n = (1.0 / larger(distance, all(1e-300))) * d;
  const Lanes reach = ri + rj, delta = reach - distance;
  Lanes3 arm_i = (ri - 0.5 * delta) * n, arm_j = (0.5 * delta - rj) * n;
  if constexpr (!spheres) arm_i = arm_i + g.ai.get(), arm_j = arm_j + g.aj.get();
  const Lanes3 v = (g.vi.get() + cross(wi, arm_i)) - (g.vj.get() + cross(wj, arm_j));
  const Springs<Lanes> law = g.law.get();
  const Lanes radius = hertz || rolls ? ri * rj / reach : Lanes{};
  const auto c = coefficients<hertz>(law, delta, root_mass, radius);
  const Touch<Lanes> touch{n, v, delta, 0.5 * dot(wi + wj, n)};
  const Lanes spring = spring_force<hertz>(law, c, delta, dot(v, n), root_mass, radius, dt);
  const Lanes remains = hertz ? kept(dem::load(g.size), c.size) : all(1);
  Lanes3 xi = g.xi.get();
  const auto contact = contact_force(c, touch, spring, remains, dt, xi);
  const Lanes3 force = contact.friction - contact.normal * n;
  Lanes3 turn_i = cross(arm_i, force), turn_j = cross(arm_j, force);
  // A moment of a pair: opposite on j, which `add` sees to as with all torques.
  if constexpr (rolls) {
    const Rolls<Lanes> t{n, wi - wj, touch.twist, contact.normal, c.k_n, radius, root_mass};
    Lanes3 roll = g.roll.get();
    const Lanes3 moment = rolling_moment(g.rolling.get(), t, remains, dt, roll);
    turn_i = turn_i + moment, turn_j = turn_j + moment;
    g.roll.set(roll);
  }
  g.xi.set(xi), g.force.set(force), g.turn_i.set(turn_i), g.turn_j.set(turn_j);
  if constexpr (hertz) store(c.size, g.size);
  store(delta / smaller(ri, rj), g.overlap);  // for the check of overlaps
}

// Adds forces in the order of the list; returns the largest overlap over the smaller radius.
// One contact after the other: neighbours in the list share particles, so lanes may not add at
// once.
template <bool spheres, bool hertz, bool rolls>
double add(const Arrays& a, PairList& list, const Contact* contacts, std::size_t count,
           const Group& g) {
  double worst = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t e = contacts[k].entry;
    Vec4& xi = list.xi[e];
    xi.x = g.xi.x[k], xi.y = g.xi.y[k], xi.z = g.xi.z[k];
    if constexpr (hertz) list.size[e] = g.size[k];
    if constexpr (rolls) list.roll[e].set(g.roll.at(k));
    // Ghosts collect what their owners compute as well; it is dropped with them.
    const std::size_t i = particle<spheres>(a, contacts[k].piece);
    const std::size_t j = particle<spheres>(a, list.entries[e].piece);
    Vec4 &fi = a.f[i], &ti = a.t[i], &fj = a.f[j], &tj = a.t[j];
    fi.x += g.force.x[k], fi.y += g.force.y[k], fi.z += g.force.z[k];
    ti.x += g.turn_i.x[k], ti.y += g.turn_i.y[k], ti.z += g.turn_i.z[k];
    fj.x -= g.force.x[k], fj.y -= g.force.y[k], fj.z -= g.force.z[k];
    tj.x -= g.turn_j.x[k], tj.y -= g.turn_j.y[k], tj.z -= g.turn_j.z[k];
    worst = g.overlap[k] > worst ? g.overlap[k] : worst;
  }
  return worst;
}

// Returns the largest overlap over the smaller radius.
template <bool spheres, bool hertz, bool rolls>
double pair_loop(const Arrays& a, const LawTable& laws, PairList& list, double dt) {
  double worst = 0;
  Group group{};
  for (std::size_t begin = 0; begin < list.touching.size(); begin += lanes) {
    const Contact* contacts = list.touching.data() + begin;
    const std::size_t count = std::min(lanes, list.touching.size() - begin);
    load<spheres, hertz, rolls>(a, laws, list, contacts, count, group);
    respond<spheres, hertz, rolls>(group, dt);
    worst = std::max(worst, add<spheres, hertz, rolls>(a, list, contacts, count, group));
  }
  return worst;
}

// The loop compiled for what these shapes and laws need.
// A flag of the laws or shapes as a whole, not of a contact: one exception among many contacts
// makes all take the general loop.
auto loop_for(bool spheres, bool hertz, bool rolls) {
  constexpr decltype(&pair_loop<false, false, false>) loops[] = {
      pair_loop<false, false, false>, pair_loop<false, false, true>, pair_loop<false, true, false>,
      pair_loop<false, true, true>,   pair_loop<true, false, false>, pair_loop<true, false, true>,
      pair_loop<true, true, false>,   pair_loop<true, true, true>};
  return loops[4 * spheres + 2 * hertz + rolls];
}

}  // namespace

// Local. Forces are made anew from nothing: balls first, then stones, each in the order of its
// list, so that every particle adds up alike on any rank; surfaces follow (`feel_surfaces`).
void Particles::Room::feel_pairs(double dt) {
  std::fill(state.f.begin(), state.f.end(), Vec4{});
  std::fill(state.t.begin(), state.t.end(), Vec4{});
  const bool spheres = shapes.only_spheres();
  if (!spheres) place(state, shapes, pieces);
  const Arrays a{spheres ? state.x.data() : pieces.x.data(),
                 pieces.body.data(),
                 state.x.data(),
                 state.v.data(),
                 state.w.data(),
                 state.f.data(),
                 state.t.data()};
  find_touching(a.piece_x, pairs);
  const auto loop = loop_for(spheres, laws.any_hertz(), laws.any_rolls());
  double worst = loop(a, laws, pairs, dt);
  if (shapes.any_stones()) worst = std::max(worst, stone_contacts.feel(scene(), dt, stones, state));
  if (worst > parameters.largest_overlap)
    report(
        fmt::format("two particles overlap by {:.3g} of the smaller radius (limit "
                    "dem.largest_overlap = {:.3g}); a smaller step, a stiffer contact or a "
                    "slower load may help",
                    worst, parameters.largest_overlap));
}

}  // namespace trackbed::dem
