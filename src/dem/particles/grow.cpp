// Growth in place: particles begin small in about the volume of the final bed and grow until they
// are in contact, instead of falling from far above it (Lubachevsky, Stillinger 1990,
// doi:10.1007/BF01025983, whose particles grow while they move freely). All growing particles have
// one size fraction and are identified by their ids, so that ghosts grow identically without a
// message.
//
// Cost: one pass over particles and pieces whenever the fraction changes; lists are rebuilt as
// often as surfaces come closer by the skin, as for motion.
#include "dem/particles/impl.hpp"

namespace trackbed::dem {

// Angular momenta are kept, so spins fall as inertias rise. `path` of the pieces bounds the motion
// of their surface: features found before remain valid accordingly. Ghosts have no angular momentum
// here: their spin is received from their owners in the next sub-step.
void Particles::Impl::grow_to(double fraction) {
  store_near_pairs(), near_valid = false;
  const double more = fraction - state.grown;
  state.grown = fraction;
  for (std::size_t b = 0; b < state.size(); ++b) derive_size(b);
  for (std::size_t b = 0; b < state.own; ++b) update_spin(b);
  if (!ready) return;
  for (std::size_t p = 0; p < pieces.body.size(); ++p) {
    const auto b = static_cast<std::size_t>(pieces.body[p]);
    const std::size_t k = shapes.begin(state.shape[b]) + p - pieces.begin[b];
    pieces.x[p].w = shapes.piece(k).w * state.scale_now(b);
    if (shapes.any_stones()) pieces.rounding[p] = shapes.core(k).radius * state.scale_now(b);
  }
  for (std::size_t b = 0; b < pieces.path.size(); ++b)
    if (state.id[b] >= state.growing) pieces.path[b] += radius(b) * more;
}

// These particles are in no list yet, so no list becomes outdated.
void Particles::grow_from(Id first, double fraction) {
  impl_->state.growing = first;
  impl_->state.grown = fraction;
}

void Particles::grow_to(double fraction) { impl_->grow_to(fraction); }
double Particles::grown() const { return impl_->state.grown; }

}  // namespace trackbed::dem
