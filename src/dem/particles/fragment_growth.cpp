// Fragments grow to the size that belongs to their mass, as long as there is space: a fragment
// waits while one of its contacts is compressed by more than a small part of its radius. Without
// this limit, fragments between loaded stones are driven apart by their growth: two stones that
// collided at 4 m/s had thirty times their energy afterwards.
#include <algorithm>
#include <unordered_map>

#include "dem/particles/impl.hpp"

namespace trackbed::dem {

namespace {

constexpr std::int64_t growths = 5;  // within `growth_steps`

struct Grown {
  std::int64_t id;
  double part;
};

}  // namespace

// One pass over the lists.
void Particles::Impl::find_growing() {
  breaking.growing.clear();
  breaking.grown_since_rebuild = breaking.next_growth = 0;
  if (breaking.totals.fragments == 0) return;           // the same on all ranks
  std::unordered_map<std::size_t, std::size_t> number;  // of own bodies, in `growing`
  for (std::size_t b = 0; b < state.size(); ++b) {
    if (!state.is_fragment(b) || state.part[b] >= 1) continue;
    if (b < state.own) number.emplace(b, breaking.growing.size());
    breaking.growing.push_back({b, state.x[b].w, {}, {}});
  }
  // The same on all ranks.
  if (comm.max(static_cast<std::int64_t>(breaking.growing.size())) > 0)
    breaking.next_growth = longest_growth * breaking.least_radius;
  if (number.empty()) return;
  const auto of = [&](std::int32_t piece) -> GrowingFragment* {
    const auto found =
        number.find(static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]));
    return found == number.end() ? nullptr : &breaking.growing[found->second];
  };
  for (const Row& row : pairs.rows)
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const Entry& entry = pairs.entries[e];
      const Vec4& shift = pairs.shifts[entry.shift];
      if (GrowingFragment* one = of(row.piece)) one->beside.push_back({entry.piece, shift});
      if (GrowingFragment* other = of(entry.piece))
        other->beside.push_back({row.piece, {-shift.x, -shift.y, -shift.z, 0}});
    }
  for (std::size_t k = 0; k < approaches.size(); ++k)
    if (GrowingFragment* one = of(approaches[k].piece)) one->approaches.push_back(k);
}

// m, by how much the radius may grow, up to the wanted length: no contact is then compressed by
// more than the allowed part of the final radius. Partners that are not in the lists are farther
// away than a fragment grows in a window (`lists_are_old`).
double Particles::Impl::space_of(const GrowingFragment& fragment, double wanted) const {
  const std::size_t b = fragment.body, p = pieces.begin[b];
  const double allowed = breaking.parameters.growth_overlap * state.scale[b];
  const Vec3 at = pieces.x[p].vec3();
  const double radius = pieces.x[p].w;
  double space = wanted;
  for (const GrowingFragment::Neighbour& other : fragment.beside) {
    const Vec4& x = pieces.x[static_cast<std::size_t>(other.piece)];
    const double gap = (x.vec3() + other.shift.vec3() - at).norm() - radius - x.w;
    // Another one that grows takes the other half.
    const auto body = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(other.piece)]);
    const bool grows = state.is_fragment(body) && state.part[body] < 1;
    space = std::min(space, grows ? (gap + allowed) / 2 : gap + allowed);
  }
  std::vector<MeshContact> found;
  for (const std::size_t k : fragment.approaches) {
    const Approach& a = approaches[k];
    const auto surface = static_cast<std::size_t>(a.surface);
    found.clear();
    meshes[surface].touch({at + a.shift, radius + wanted}, a.triangles, *surfaces[surface], 0,
                          found);
    for (const MeshContact& c : found) space = std::min(space, c.distance - radius + allowed);
  }
  return std::max(space, 0.0);
}

void Particles::Impl::set_part(std::size_t b, double part) {
  state.part[b] = part;
  derive_size(b);
  if (b < state.own) update_spin(b);
  for (std::size_t p = pieces.begin[b]; p < pieces.begin[b + 1]; ++p)
    pieces.x[p].w = shapes.piece(shapes.begin(state.shape[b])).w * state.scale_now(b);
}

// Every few sub-steps, as near pairs are gathered again after each growth. Owners decide and send
// the sizes in one small message.
void Particles::Impl::grow_fragments(int steps_of_window) {
  if (breaking.next_growth == 0) return;  // the same on all ranks
  const BreakageParameters& p = breaking.parameters;
  const std::int64_t every = std::max<std::int64_t>(p.growth_steps / growths, 1);
  if (steps % every >= steps_of_window) return;
  const double passed = static_cast<double>(std::max<std::int64_t>(every, steps_of_window));
  const double part = 0.5 * passed / static_cast<double>(p.growth_steps);
  std::vector<Grown> grown;
  for (const GrowingFragment& fragment : breaking.growing) {
    const std::size_t b = fragment.body;
    if (b >= state.own) continue;
    const double left = (1 - state.part[b]) * state.scale[b];
    const double wanted = std::min({part * state.scale[b], breaking.next_growth, left});
    // Pieces are where they were in the last sub-step or at the rebuild, that is, where they are.
    const double space = space_of(fragment, wanted);
    if (space >= std::min(wanted, 0.5 * p.growth_overlap * state.scale[b]))
      grown.push_back({state.id[b], std::min(1.0, state.part[b] + space / state.scale[b])});
  }
  grown = comm.all_gather(std::span<const Grown>(grown));
  if (grown.empty()) return;
  store_near_pairs(), near_valid = false;
  std::unordered_map<Id, double> parts;
  for (const Grown& g : grown) parts.emplace(g.id, g.part);
  for (const GrowingFragment& fragment : breaking.growing) {
    const auto found = parts.find(state.id[fragment.body]);
    if (found == parts.end()) continue;
    set_part(fragment.body, found->second);
    breaking.grown_since_rebuild =
        std::max(breaking.grown_since_rebuild, state.x[fragment.body].w - fragment.radius);
  }
  std::erase_if(breaking.growing,
                [&](const GrowingFragment& fragment) { return state.part[fragment.body] >= 1; });
}

}  // namespace trackbed::dem
