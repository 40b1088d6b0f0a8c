// Growth in place: particles begin small in about the room of the final bed and swell until they
// press on each other, instead of falling from far above it (Lubachevsky, Stillinger 1990,
// doi:10.1007/BF01025983, who grow while particles fly). One share for all that grow, told by their
// ids, so that ghosts grow alike without a message.
//
// Cost: one pass over particles and pieces whenever the share changes; lists are made anew as often
// as surfaces come closer by the skin, as for motion.
#include "room.hpp"

namespace trackbed::dem {

// Angular momenta stay, so spins fall as inertias rise. Pieces keep how far their surface has come
// at most, `path`: features found before hold as long as that says.
// Ghosts have no angular momentum here: their spin comes from their owners in the next sub-step.
void Particles::Room::grow_to(double share) {
  store_near_pairs(), near_valid = false;
  const double more = share - state.grown;
  state.grown = share;
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

// Nothing of them has been seen by others yet, so no list gets old.
void Particles::grow_from(Id first, double share) {
  room_->state.growing = first;
  room_->state.grown = share;
}

void Particles::grow_to(double share) { room_->grow_to(share); }
double Particles::grown() const { return room_->state.grown; }

}  // namespace trackbed::dem
