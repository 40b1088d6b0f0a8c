// The law (stone_law.hpp) on overlapping pairs.
// Gather, respond, add: as the loop of pair_contacts.cpp, for what `StoneContacts` found. Here a
// lane's law is far cheaper than finding its overlap, so rooted and linear laws share one loop.
#include "stone_law.hpp"

#include "stones.hpp"

namespace trackbed::dem {

namespace {

std::size_t body(const Scene& scene, std::int32_t piece) {
  return static_cast<std::size_t>(scene.pieces.body[static_cast<std::size_t>(piece)]);
}

// Eight contacts on their way into lanes and back.
struct alignas(64) StoneGroup {
  Lane3 d, N, T, x, vi, vj, wi, wj;
  double M[lanes], spread[lanes], root_mass[lanes], radius[lanes], rolling_radius[lanes];
  LawLanes law;
  RollingLanes rolling;
  Lane3 xi, roll;
  double turn[lanes], size[lanes], ring[lanes];
  Lane3 force, turn_i, turn_j;

  [[gnu::always_inline]] StoneTouch<Lanes> touch() const {
    return {d.get(),
            N.get(),
            T.get(),
            x.get(),
            vi.get(),
            vj.get(),
            wi.get(),
            wj.get(),
            dem::load(M),
            dem::load(spread),
            dem::load(root_mass),
            dem::load(radius),
            Lanes{},
            law.get(),
            rolling.get(),
            dem::load(rolling_radius)};
  }
};

// Places from the centre of i, the periodic shift in the difference, as in the loop over balls.
void load(const Overlap& o, const Scene& scene, const StoneList& list, std::size_t k,
          StoneGroup& g) {
  const State& s = scene.state;
  const Entry& entry = list.entries[o.entry];
  const std::size_t i = body(scene, o.piece), j = body(scene, entry.piece);
  const Vec4& h = list.shifts[entry.shift];
  g.d.put(k, s.x[j].x - s.x[i].x + h.x, s.x[j].y - s.x[i].y + h.y, s.x[j].z - s.x[i].z + h.z);
  g.N.put(k, o.wrench.N), g.T.put(k, o.wrench.T), g.x.put(k, o.wrench.x);
  g.M[k] = o.wrench.M, g.spread[k] = o.wrench.spread;
  g.vi.put(k, s.v[i]), g.vj.put(k, s.v[j]);
  g.wi.put(k, s.w[i]), g.wj.put(k, s.w[j]);
  const Vec4 &xi = list.xi[o.entry], &turn = list.turn[o.entry];
  g.xi.put(k, xi), g.root_mass[k] = xi.w;
  g.turn[k] = turn.x, g.size[k] = turn.y, g.ring[k] = turn.z;
  // The curvature of a contact is that of the roundings; rolling takes the balls around the pieces.
  const double ri = scene.pieces.rounding[static_cast<std::size_t>(o.piece)];
  const double rj = scene.pieces.rounding[static_cast<std::size_t>(entry.piece)];
  g.law.set(k, scene.laws[entry.law]), g.radius[k] = ri * rj / (ri + rj);
  if (list.roll.empty()) return;
  const double bi = scene.pieces.x[static_cast<std::size_t>(o.piece)].w;
  const double bj = scene.pieces.x[static_cast<std::size_t>(entry.piece)].w;
  g.rolling.set(k, scene.laws[entry.law].rolling), g.rolling_radius[k] = bi * bj / (bi + bj);
  g.roll.put(k, list.roll[o.entry]);
}

// In the order of the list, ghosts too; those are dropped.
void add(const Overlap& o, const Scene& scene, const StoneGroup& g, std::size_t k, StoneList& list,
         State& state) {
  list.xi[o.entry].set(g.xi.at(k)), list.turn[o.entry] = {g.turn[k], g.size[k], g.ring[k], 0};
  if (!list.roll.empty()) list.roll[o.entry].set(g.roll.at(k));
  const std::size_t i = body(scene, o.piece), j = body(scene, list.entries[o.entry].piece);
  Vec4 &fi = state.f[i], &ti = state.t[i], &fj = state.f[j], &tj = state.t[j];
  fi.x += g.force.x[k], fi.y += g.force.y[k], fi.z += g.force.z[k];
  ti.x += g.turn_i.x[k], ti.y += g.turn_i.y[k], ti.z += g.turn_i.z[k];
  fj.x -= g.force.x[k], fj.y -= g.force.y[k], fj.z -= g.force.z[k];
  tj.x -= g.turn_j.x[k], tj.y -= g.turn_j.y[k], tj.z -= g.turn_j.z[k];
}

// Rounding, not size: beyond it the cores overlap.
double overlap_over_radius(const Overlap& o, const Scene& scene, const StoneList& list) {
  const auto other = static_cast<std::size_t>(list.entries[o.entry].piece);
  return o.wrench.M / std::min(scene.pieces.rounding[static_cast<std::size_t>(o.piece)],
                               scene.pieces.rounding[other]);
}

template <bool rolls>
void respond_all(StoneGroup& g, double dt) {
  StoneStretch<Lanes> h{g.xi.get(), {}, dem::load(g.turn), dem::load(g.size), dem::load(g.ring)};
  if constexpr (rolls) h.roll = g.roll.get();
  const StoneForce<Lanes> f = respond<rolls>(g.touch(), dt, h);
  g.force.set(f.force), g.turn_i.set(f.turn_i), g.turn_j.set(f.turn_j);
  g.xi.set(h.xi), store(h.turn, g.turn), store(h.size, g.size), store(h.ring, g.ring);
  if constexpr (rolls) g.roll.set(h.roll);
}

}  // namespace

double feel_stones(const std::vector<Overlap>& overlaps, const Scene& scene, double dt,
                   StoneList& list, State& state) {
  double worst = 0;
  StoneGroup group{};
  const auto respond_to = list.roll.empty() ? respond_all<false> : respond_all<true>;
  for (std::size_t begin = 0; begin < overlaps.size(); begin += lanes) {
    const std::size_t count = std::min(lanes, overlaps.size() - begin);
    for (std::size_t k = 0; k < lanes; ++k)  // spare lanes repeat a pair, unused
      load(overlaps[begin + (k < count ? k : 0)], scene, list, k, group);
    respond_to(group, dt);
    for (std::size_t k = 0; k < count; ++k) {
      const Overlap& o = overlaps[begin + k];
      add(o, scene, group, k, list, state);
      worst = std::max(worst, overlap_over_radius(o, scene, list));
    }
  }
  return worst;
}

}  // namespace trackbed::dem
