// The law (stone_law.hpp) on blocks of pairs: the motion of eight pairs is read as rows and
// transposed, the law is computed in the lanes of the wrenches and histories, and the forces of
// each pair are stored until they are added in the order of the list.
#include "dem/contact/stone_law.hpp"

#include <algorithm>

#include "dem/lanes/rows.hpp"
#include "dem/state/rotation.hpp"

namespace trackbed::dem {

StoneLaw::StoneLaw(const Scene& scene, double dt, bool rolls, PairForces& forces)
    : scene_(scene), dt_(dt), rolls_(rolls), forces_(forces) {}

void StoneLaw::prefetch(const Block& block) const {
  const State& s = scene_.state;
  for (std::size_t k = 0; k < lanes; ++k) {
    __builtin_prefetch(&s.v[block.j[k]]);
    __builtin_prefetch(&s.w[block.j[k]]);
  }
}

namespace {

// The history of a pair that is not in contact is zero.
template <bool rolls>
[[gnu::always_inline]] inline void store_history(Block& block, Mask touching,
                                                 const StoneStretch<Lanes>& h) {
  const Lanes zero = all(0);
  const Lanes3 zeros{zero, zero, zero};
  block.xi = select(touching, h.xi, zeros);
  block.turn = select(touching, h.turn, zero), block.size = select(touching, h.size, zero);
  block.ring = select(touching, h.ring, zero);
  if constexpr (rolls) block.roll = select(touching, h.roll, zeros);
}

}  // namespace

template <bool rolls, bool accounts>
void StoneLaw::respond_to(std::size_t number, Block& block, const WrenchLanes& w) {
  const State& s = scene_.state;
  const auto i = [&](std::size_t k) { return block.i[k]; };
  const auto j = [&](std::size_t k) { return block.j[k]; };
  StoneStretch<Lanes> h{block.xi, {}, block.turn, block.size, block.ring};
  if constexpr (rolls) h.roll = block.roll;
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
                                block.root_mass,
                                block.radius,
                                block.inverse_moment_i,
                                block.inverse_moment_j,
                                Lanes{},
                                law_.get(),
                                rolling_.get(),
                                block.rolling_radius};
  // One by one: few contacts begin or end in a step.
  const auto yielding = [&](const Lanes3& S, Mask may_end) {
    Lanes sum = all(0);
    for (std::size_t k = 0; k < lanes; ++k)
      if (may_end[k] != 0)
        sum[k] = inverse_mass_of_turning(s, block.i[k], {w.T.x[k], w.T.y[k], w.T.z[k]}) +
                 inverse_mass_of_turning(s, block.j[k], {S.x[k], S.y[k], S.z[k]});
    return sum;
  };
  const StoneForce<Lanes> f = dem::respond<rolls>(touch, yielding, dt_, h);
  const Mask touching = w.M > all(0);
  store_history<rolls>(block, touching, h);
  const Lanes zero = all(0);
  const auto leave = [&](Vec4 PairForce::*part, const Lanes3& v, Lanes fourth) {
    PairForce* slot = forces_.data() + lanes * number;
    to_rows({select(touching, v.x, zero), select(touching, v.y, zero), select(touching, v.z, zero),
             select(touching, fourth, zero)},
            [=](std::size_t k, Four row) { put(slot[k].*part, row); });
  };
  leave(&PairForce::force, f.force, accounts ? f.spent.damping : zero);
  leave(&PairForce::turn_i, f.turn_i, accounts ? f.spent.friction : zero);
  leave(&PairForce::turn_j, f.turn_j, accounts ? -f.spent.friction : zero);
}

void StoneLaw::respond(std::size_t number, Block& block, const WrenchLanes& w) {
  if (law_number_ != block.law) {
    const Law& law = scene_.laws[block.law];
    for (std::size_t k = 0; k < lanes; ++k) law_.set(k, law), rolling_.set(k, law.rolling);
    law_number_ = block.law;
  }
  if (rolls_)
    scene_.accounts ? respond_to<true, true>(number, block, w)
                    : respond_to<true, false>(number, block, w);
  else
    scene_.accounts ? respond_to<false, true>(number, block, w)
                    : respond_to<false, false>(number, block, w);
  // Over the smaller rounding, not the size: if it is exceeded the cores overlap.
  const Lanes half = larger(block.half, -block.half);
  worst_ = larger(w.M / (0.5 * block.reach - half), worst_);
}

double StoneLaw::largest_overlap() const {
  double worst = 0;
  for (std::size_t k = 0; k < lanes; ++k) worst = std::max(worst, worst_[k]);
  return worst;
}

// Ghosts too; their sums are dropped.
void add(const std::vector<PlaceOfPair>& order, const PairForces& forces, State& state) {
  const auto plus = [](Vec4& to, Four v) { put(to, four(to) + v); };
  const auto minus = [](Vec4& to, Four v) { put(to, four(to) - v); };
  const Four opposite = {-1, -1, -1, 1};  // what is dissipated has no direction
  constexpr std::size_t ahead = 12;       // pairs: slots are in no order of addresses
  for (std::size_t n = 0; n < order.size(); ++n) {
    if (n + ahead < order.size() && order[n + ahead].slot != StoneBlocks::nowhere)
      for (const Vec4 PairForce::*part : {&PairForce::force, &PairForce::turn_j})
        __builtin_prefetch(&(forces[order[n + ahead].slot].*part));
    const PlaceOfPair& pair = order[n];
    if (pair.slot == StoneBlocks::nowhere) continue;
    const PairForce& force = forces[pair.slot];
    const Four f = four(force.force);
    plus(state.f[pair.i], f), plus(state.t[pair.i], four(force.turn_i));
    plus(state.f[pair.j], opposite * f), minus(state.t[pair.j], four(force.turn_j));
  }
}

}  // namespace trackbed::dem
