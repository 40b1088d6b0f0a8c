// The law (stone_law.hpp) on blocks of pairs: the motion and the history of eight pairs are read as
// rows and transposed, the law runs in the lanes of the wrenches, and the forces of each pair wait
// for the pass that adds them in the order of the list.
#include "stone_law.hpp"

#include <algorithm>

#include "rows.hpp"

namespace trackbed::dem {

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

// The history of a pair that does not touch is zero. Rows of lanes in use only are stored: the
// entry of another may be in another block by now.
void StoneLaw::store_history(const Block& block, Mask touching, const StoneStretch<Lanes>& h,
                             Lanes root_mass) {
  const Lanes zero = all(0);
  const auto keep = [&](Lanes value) { return select(touching, value, zero); };
  const auto store_rows = [&](std::vector<Vec4>& to, const Lanes4& v) {
    to_rows(v, [&](std::size_t k, Four row) {
      if (block.used >> k & 1) put(to[block.entry[k]], row);
    });
  };
  store_rows(list_.xi, {keep(h.xi.x), keep(h.xi.y), keep(h.xi.z), root_mass});
  store_rows(list_.turn, {keep(h.turn), keep(h.size), keep(h.ring), zero});
  if (!list_.roll.empty())
    store_rows(list_.roll, {keep(h.roll.x), keep(h.roll.y), keep(h.roll.z), zero});
}

template <bool rolls>
void StoneLaw::respond_to(std::size_t number, const Block& block, const WrenchLanes& w) {
  const State& s = scene_.state;
  const auto i = [&](std::size_t k) { return block.i[k]; };
  const auto j = [&](std::size_t k) { return block.j[k]; };
  const auto e = [&](std::size_t k) { return block.entry[k]; };
  const Lanes4 xi = rows(list_.xi.data(), e), turn = rows(list_.turn.data(), e);
  StoneStretch<Lanes> h{xi.xyz(), {}, turn.x, turn.y, turn.z};
  if constexpr (rolls) h.roll = rows(list_.roll.data(), e).xyz();
  const StoneTouch<Lanes> touch{w.d,
                                w.N,
                                w.T,
                                w.x,
                                rows(s.v.data(), i).xyz(),
                                rows(s.v.data(), j).xyz(),
                                rows(s.w.data(), i).xyz(),
                                rows(s.w.data(), j).xyz(),
                                w.M,
                                w.spread,
                                xi.w,
                                block.radius,
                                Lanes{},
                                law_.get(),
                                rolling_.get(),
                                block.rolling_radius};
  const StoneForce<Lanes> f = dem::respond<rolls>(touch, dt_, h);
  const Mask touching = w.M > all(0);
  store_history(block, touching, h, xi.w);
  const auto leave = [&](std::vector<Vec4>& to, const Lanes3& v) {
    Vec4* slot = to.data() + lanes * number;
    const Lanes zero = all(0);
    to_rows({select(touching, v.x, zero), select(touching, v.y, zero), select(touching, v.z, zero),
             zero},
            [slot](std::size_t k, Four row) { put(slot[k], row); });
  };
  leave(forces_.force, f.force), leave(forces_.turn_i, f.turn_i), leave(forces_.turn_j, f.turn_j);
}

void StoneLaw::respond(std::size_t number, const Block& block, const WrenchLanes& w) {
  if (law_number_ != block.law) {
    const Law& law = scene_.laws[block.law];
    for (std::size_t k = 0; k < lanes; ++k) law_.set(k, law), rolling_.set(k, law.rolling);
    law_number_ = block.law;
  }
  if (list_.roll.empty())
    respond_to<false>(number, block, w);
  else
    respond_to<true>(number, block, w);
  // Over the smaller rounding, not the size: beyond it the cores overlap.
  const Lanes half = larger(block.half, -block.half);
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
