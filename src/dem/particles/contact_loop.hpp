// Contacts with their forces and energies, as they were computed last.
#pragma once

#include "dem/particles/impl.hpp"

namespace trackbed::dem {

// Elastic part of a contact's force on the first piece. Dampers are left out: they depend on
// velocities of half a sub-step earlier, which are no longer available.
inline Vec3 elastic_force(const Law& law, double delta, double radius, const Vec4& xi,
                          const Vec3& n) {
  const auto c = coefficients<true>(law.springs, delta, 0.0, radius);
  return -c.k_n * delta * n - c.k_s * xi.vec3();
}

// Contacts of this rank: `visit(view, elastic energy in J, first, second, law, radius)` with the
// numbers of both particles, `no_particle` for a surface, and the radius that the law takes, m.
// Local. A contact across ranks is known on both; the owner of the lower id counts it. Order:
// balls, stones, surfaces, each in the order of the lists, which is the same for the contacts of a
// particle on any rank.
struct Particles::ContactLoop {
  static constexpr std::size_t no_particle = static_cast<std::size_t>(-1);
  const Particles::Impl& impl;
  const State& state;
  const Shapes& shapes;
  const Pieces& pieces;
  const PairList& pairs;
  const StoneList& stones;
  const std::vector<Overlap> overlaps;  // of stones, as computed last
  const std::vector<Approach>& approaches;
  const LawTable& laws;

  explicit ContactLoop(const Particles::Impl& r)
      : impl(r),
        state(r.state),
        shapes(r.shapes),
        pieces(r.pieces),
        pairs(r.pairs),
        stones(r.stones),
        overlaps(r.stone_contacts.overlaps(r.scene(), r.stones)),
        approaches(r.approaches),
        laws(r.laws) {}

  Vec4 piece(std::size_t p) const {
    const auto b = static_cast<std::size_t>(pieces.body[p]);
    return shapes.only_spheres() ? state.x[b] : pieces.x[p];
  }

  // The contacts that this rank counts: the owner of the lower id, which the first piece has.
  template <class Visit>
  void run(Visit&& visit) const {
    visit_where([&](std::size_t first) { return first < state.own; }, visit);
  }
  // All contacts of own particles, and maybe those of ghosts.
  template <class Visit>
  void run_known(Visit&& visit) const {
    visit_where([](std::size_t) { return true; }, visit);
  }

 private:
  template <class Takes, class Visit>
  void visit_where(const Takes& takes, Visit& visit) const {
    impl.visit_touching([&](std::int32_t i, std::uint32_t e, const Vec4& xi, const Vec4& roll) {
      if (takes(body(i))) pair(i, e, xi, roll, visit);
    });
    for (const Overlap& o : overlaps)
      if (takes(body(o.piece))) stone_pair(o, visit);
    for (const Approach& a : approaches)
      for (const Approach::Patch& p : a.patches) surface(a, p, visit);
  }

  std::size_t body(std::int32_t piece) const {
    return static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]);
  }

  Vec3 centre(std::int32_t piece) const { return state.x[body(piece)].vec3(); }

  // Normal spring along the generalised normal, tangential spring, and the ring that resists
  // torsion: 1/2 k_s spread turn^2, J (stone_law.hpp).
  template <class Visit>
  void stone_pair(const Overlap& o, Visit& visit) const {
    const Entry& entry = stones.entries[o.entry];
    const auto i = static_cast<std::size_t>(o.piece), j = static_cast<std::size_t>(entry.piece);
    const double ri = pieces.rounding[i], rj = pieces.rounding[j], radius = ri * rj / (ri + rj);
    const Law& law = laws[entry.law];
    const Vec4& xi = stones.xi[o.entry];
    const auto c = coefficients<true>(law.springs, o.wrench.M, 0.0, radius);
    const Vec3 force = -c.k_n * o.wrench.M * o.wrench.N - c.k_s * xi.vec3();
    const double turn = stones.turn[o.entry].x;
    visit(ContactView{state.id[body(o.piece)], state.id[body(entry.piece)], pieces.x[i].vec3(),
                      pieces.x[j].vec3() + stones.shifts[entry.shift].vec3(), force, o.wrench.M,
                      centre(o.piece), centre(entry.piece) + stones.shifts[entry.shift].vec3(),
                      o.wrench.N.normalized(), centre(o.piece) + o.wrench.x},
          stored_energy(law, o.wrench.M, radius, xi) + 0.5 * c.k_s * o.wrench.spread * turn * turn +
              rolling(stones, o.entry, o.wrench.M, radius),
          body(o.piece), body(entry.piece), law, radius);
  }

  // From the present positions: for balls the overlap is recomputed at low cost.
  template <class Visit>
  void pair(std::int32_t i, std::uint32_t e, const Vec4& xi, const Vec4& roll, Visit& visit) const {
    const Entry& entry = pairs.entries[e];
    const std::size_t bi = body(i), bj = body(entry.piece);
    const Vec4 a = piece(static_cast<std::size_t>(i));
    const Vec4 b = piece(static_cast<std::size_t>(entry.piece));
    const Vec3 to = b.vec3() + pairs.shifts[entry.shift].vec3();
    const Vec3 d = to - a.vec3();
    const double reach = a.w + b.w, delta = reach - d.norm(), radius = a.w * b.w / reach;
    const Law& law = laws[entry.law];
    const Vec3 force = elastic_force(law, delta, radius, xi, d.normalized());
    visit(ContactView{state.id[bi], state.id[bj], a.vec3(), to, force, delta, state.x[bi].vec3(),
                      state.x[bj].vec3() + pairs.shifts[entry.shift].vec3(), d.normalized(),
                      a.vec3() + (a.w - delta / 2) * d.normalized()},
          stored_energy(law, delta, radius, xi) + rolling_energy(law, delta, radius, roll), bi, bj,
          law, radius);
  }

  double rolling(const StoneList& list, std::uint32_t e, double delta, double radius) const {
    return list.roll.empty()
               ? 0
               : rolling_energy(laws[list.entries[e].law], delta, radius, list.roll[e]);
  }

  // As computed last: finding the contacts of a stone again would be expensive.
  template <class Visit>
  void surface(const Approach& a, const Approach::Patch& p, Visit& visit) const {
    if (!(p.radius > 0)) return;  // loaded from a checkpoint, not yet computed
    const auto i = static_cast<std::size_t>(a.piece);
    const Law& law = laws[static_cast<std::size_t>(a.law)];
    const auto c = coefficients<true>(law.springs, p.overlap, 0.0, p.radius);
    const Vec3 force = elastic_force(law, p.overlap, p.radius, p.xi, p.N);
    visit(ContactView{state.id[body(a.piece)], -1 - a.surface, piece(i).vec3(), p.point, force,
                      p.overlap, centre(a.piece), p.point, p.N.normalized(), p.point},
          stored_energy(law, p.overlap, p.radius, p.xi) + 0.5 * c.k_s * p.spread * p.turn * p.turn +
              rolling_energy(law, p.overlap, p.radius, p.roll),
          body(a.piece), no_particle, law, p.radius);
  }
};

}  // namespace trackbed::dem
