// The law (stone_law.hpp) on blocks of pairs: the motion and the history of eight pairs are read as
// rows and transposed, the law runs in the lanes of the wrenches, and the forces of each pair wait
// for the pass that adds them in the order of the list.
#include "stone_law.hpp"

#include <algorithm>

#include "rows.hpp"

namespace trackbed::dem {

namespace {

[[gnu::always_inline]] inline void put(double (&to)[lanes], Lanes v) {
  *reinterpret_cast<Lanes*>(to) = v;
}
[[gnu::always_inline]] inline Lanes get(const double (&from)[lanes]) {
  return *reinterpret_cast<const Lanes*>(from);
}
[[gnu::always_inline]] inline void put(Lane3& to, const Lanes3& v) {
  put(to.x, v.x), put(to.y, v.y), put(to.z, v.z);
}
[[gnu::always_inline]] inline Lanes3 get(const Lane3& from) {
  return {get(from.x), get(from.y), get(from.z)};
}

}  // namespace

StoneLaw::StoneLaw(const Scene& scene, double dt, StoneList& list, PairForces& forces)
    : scene_(scene), dt_(dt), list_(list), forces_(forces) {}

void StoneLaw::prefetch(const Block& block) const {
  const State& s = scene_.state;
  for (std::size_t k = 0; k < lanes; ++k) {
    __builtin_prefetch(&list_.xi[block.entry[k]], 1);
    __builtin_prefetch(&list_.turn[block.entry[k]], 1);
    __builtin_prefetch(&s.v[block.j[k]]);
    __builtin_prefetch(&s.w[block.j[k]]);
  }
}

template <bool rolls>
void StoneLaw::respond_to(const Block& block, const WrenchLanes& w, Mask touching) {
  StoneGroup& g = group_;
  const State& s = scene_.state;
  const auto i = [&](std::size_t k) { return block.i[k]; };
  const auto j = [&](std::size_t k) { return block.j[k]; };
  const auto e = [&](std::size_t k) { return block.entry[k]; };
  put(g.d, w.d), put(g.N, w.N), put(g.T, w.T), put(g.x, w.x);
  put(g.M, w.M), put(g.spread, w.spread);
  put(g.vi, rows(s.v.data(), i).xyz()), put(g.vj, rows(s.v.data(), j).xyz());
  put(g.wi, rows(s.w.data(), i).xyz()), put(g.wj, rows(s.w.data(), j).xyz());
  const Lanes4 xi = rows(list_.xi.data(), e);
  put(g.xi, xi.xyz()), put(g.root_mass, xi.w);
  put(g.turn, rows(list_.turn.data(), e).x);
  put(g.radius, block.radius);
  if constexpr (rolls) {
    put(g.rolling.radius, block.rolling_radius);
    put(g.rolling.roll, rows(list_.roll.data(), e).xyz());
  }
#pragma omp simd
  for (std::size_t k = 0; k < lanes; ++k) dem::respond<rolls>(g, k, dt_);
  const Lanes zero = all(0);
  const Lanes3 zeros{zero, zero, zero};
  for (Lane3* out : {&g.force, &g.turn_i, &g.turn_j, &g.xi})
    put(*out, select(touching, get(*out), zeros));
  put(g.turn, select(touching, get(g.turn), zero));
  if constexpr (rolls) put(g.rolling.roll, select(touching, get(g.rolling.roll), zeros));
}

// Of lanes that are in use: the entry of another may be at home in another block by now.
void StoneLaw::store_history(const Block& block, Mask) {
  const StoneGroup& g = group_;
  const auto store = [&](std::vector<Vec4>& to, const Lanes4& v) {
    to_rows(v, [&](std::size_t k, Four row) {
      if (block.used >> k & 1) dem::put(to[block.entry[k]], row);
    });
  };
  const Lanes3 xi = get(g.xi);
  store(list_.xi, {xi.x, xi.y, xi.z, get(g.root_mass)});
  store(list_.turn, {get(g.turn), all(0), all(0), all(0)});
  if (list_.roll.empty()) return;
  const Lanes3 roll = get(g.rolling.roll);
  store(list_.roll, {roll.x, roll.y, roll.z, all(0)});
}

void StoneLaw::respond(std::size_t number, const Block& block, const WrenchLanes& w) {
  if (law_ != block.law) {
    const Law& law = scene_.laws[block.law];
    for (std::size_t k = 0; k < lanes; ++k) {
      group_.law.set(k, law);
      group_.rolling.set(k, law.rolling, 0, {});
    }
    law_ = block.law;
  }
  const Mask touching = w.M > all(0);
  if (list_.roll.empty())
    respond_to<false>(block, w, touching);
  else
    respond_to<true>(block, w, touching);
  store_history(block, touching);
  const auto store = [&](std::vector<Vec4>& to, const Lanes3& v) {
    Vec4* slot = to.data() + lanes * number;
    to_rows({v.x, v.y, v.z, all(0)}, [slot](std::size_t k, Four row) { dem::put(slot[k], row); });
  };
  store(forces_.force, get(group_.force));
  store(forces_.turn_i, get(group_.turn_i));
  store(forces_.turn_j, get(group_.turn_j));
  // Over the smaller rounding, not the size: beyond it the cores overlap.
  const Lanes half = block.half > all(0) ? block.half : -block.half;
  worst_ = larger(w.M / (0.5 * block.reach - half), worst_);
}

double StoneLaw::largest_overlap() const {
  double worst = 0;
  for (std::size_t k = 0; k < lanes; ++k) worst = std::max(worst, worst_[k]);
  return worst;
}

// Ghosts too; what they collect is dropped with them.
void add(const std::vector<PlaceOfPair>& order, const PairForces& forces, State& state) {
  const auto plus = [](Vec4& to, Four v) { put(to, four(to) + v); };
  const auto minus = [](Vec4& to, Four v) { put(to, four(to) - v); };
  for (const PlaceOfPair& pair : order) {
    const Four f = four(forces.force[pair.slot]);
    plus(state.f[pair.i], f), plus(state.t[pair.i], four(forces.turn_i[pair.slot]));
    minus(state.f[pair.j], f), minus(state.t[pair.j], four(forces.turn_j[pair.slot]));
  }
}

}  // namespace trackbed::dem
