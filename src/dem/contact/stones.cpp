// From neighbour list to forces: selection of pairs (`check_entry`), of their features
// (`update_features`), their forces (`compute_forces`), and the rare overlap of cores
// (`check_core_overlap`). Why a smooth maximum: docs/decisions/stone-contact.md.
#include "dem/contact/stones.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackbed::dem {

namespace {

// Distance by which a pair may approach before its features are searched again: its motion in this
// number of sub-steps at its present pace (a search costs many times a sub-step), within these
// fractions of the sum of its radii. The fewer features are within the margin, the less each
// sub-step has to compute: in a bed at rest the minimum applies, which is still some twenty times
// the error of `Pose` (1e-6 of the size).
constexpr double margin_steps = 100, least_margin = 0.001, most_margin = 0.15;
// A pair releases its lane if its gap will last for this number of sub-steps at the present pace,
// and is at least this fraction of the sum of its radii: taking a lane again costs a few sub-steps
// in a lane.
constexpr double gap_steps = 10, least_gap = 0.002;
// Cores nearer than this fraction of the sum of radii are checked for overlap. The motion in a
// sub-step is a small part of it.
constexpr double close = 0.05;
// Below this fraction a margin counts as used up: the rest would be checked again at once.
constexpr double used_up = 0.1;

}  // namespace

StoneContacts::Pose StoneContacts::pose(const Scene& scene, const StoneList& list,
                                        const Check& pair, std::uint32_t entry) {
  const std::size_t i = pair.i, j = pair.j;
  const State& s = scene.state;
  const Quat back = quat(s.q[i]).conjugate(), q = back * quat(s.q[j]);
  const Vec3 shift = list.shifts[list.entries[entry].shift].vec3();
  const Vec3 x = back * (s.x[j].vec3() - s.x[i].vec3() + shift);
  return {{static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())},
          {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
           static_cast<float>(q.w())},
          static_cast<float>(s.x[i].w + s.x[j].w)};
}

// Largest possible approach of two surface points, m, with r the radius of the ball around j: the
// displacement of its centre and the arc of its farthest point relative to i, and growth. Common
// motion of both is not included, nor are paths that returned. Roundings are those of `float`.
double StoneContacts::closed(const Pose& a, const Pose& b, double r) {
  double moved = 0, turned = 0, far = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = static_cast<double>(b.x[k]) - static_cast<double>(a.x[k]);
    moved += d * d, far += std::abs(static_cast<double>(b.x[k]));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const double d = static_cast<double>(b.q[k]) - static_cast<double>(a.q[k]);
    turned += d * d;
  }
  constexpr double rounding = 1e-6;  // several units in the last place of each number
  const double grown = static_cast<double>(b.size) - static_cast<double>(a.size);
  return std::sqrt(moved) + 2.1 * r * std::sqrt(turned) + std::abs(grown) +
         rounding * (far + static_cast<double>(b.size));
}

// The sum of both paths is only a bound, and a poor one where stones move together or oscillate, as
// in a bed that is loaded or shaken. So when they have used up a margin, the relative pose gives
// the remaining margin, at a fraction of the cost of a new search for features.
bool StoneContacts::still_valid(const Scene& scene, const StoneList& list, std::uint32_t e,
                                double path) {
  Reach& reach = reaches_[e];
  const double used =
      closed(poses_[e], pose(scene, list, checks_[e], e), scene.state.x[checks_[e].j].w);
  const double left = reach.slack - used, no_contact = reach.gap - used;
  // A gap that is used up is not checked again: from then on distances are computed.
  if (!(no_contact > used_up * reach.gap)) reach.gap = 0;
  if (!(left > used_up * reach.slack)) return false;
  reach.until = std::max(reach.until, path + left);
  if (reach.gap > 0) reach.no_contact = std::min(reach.until, path + no_contact);
  return true;
}

// Numbers of entries, pieces and bodies have changed and paths begin at 0; the data kept for a pair
// refer to corners of its cores only. Lists ascend by both keys, so one pass over old and new ones
// identifies the pairs that existed before. In a moving bed lists are rebuilt every 20 sub-steps,
// features rarely.
void StoneContacts::reset(const Scene& scene, const StoneList& list) {
  const auto body = [&](std::int32_t piece) {
    return static_cast<std::size_t>(scene.pieces.body[static_cast<std::size_t>(piece)]);
  };
  const auto key = [&](std::int32_t piece) {
    const std::size_t b = body(piece);
    return piece_key(scene.state.id[b], static_cast<std::size_t>(piece) - scene.pieces.begin[b]);
  };
  std::vector<Reach> reaches(list.entries.size());
  std::vector<Pose> poses(list.entries.size());
  std::vector<Key> keys;
  keys.reserve(list.entries.size());
  checks_.clear(), pieces_.clear();
  std::size_t old = 0;
  for (const Row& row : list.rows)
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const std::int32_t other = list.entries[e].piece;
      pieces_.push_back(row.piece);
      checks_.push_back({-1, static_cast<std::uint32_t>(body(row.piece)),
                         static_cast<std::uint32_t>(body(other)), 0});
      const Key wanted = keys.emplace_back(Key{key(row.piece), key(other)});
      while (old < keys_.size() && keys_[old] < wanted) ++old;
      if (old == keys_.size() || keys_[old] != wanted) continue;
      reaches[e] = reaches_[old], poses[e] = poses_[old];
      reaches[e].until = reaches[e].no_contact = -1;
      ++old;  // a partner listed twice, across a periodic side: two different entries
    }
  reaches_.swap(reaches), poses_.swap(poses), keys_.swap(keys);
  find_couples(list);
  compact();
  live_ = words_.size();
  order_.clear();
  blocks_.reset(list.entries.size());
  grown_ = scene.state.grown;
}

// Feature words are appended when the features of a pair are searched again, since there may be
// more than before. This removes those that no pair uses any longer.
void StoneContacts::compact() {
  std::vector<FeatureWord> kept;
  kept.reserve(words_.size());
  for (Reach& r : reaches_) {
    const auto from = words_.begin() + r.begin;
    r.begin = static_cast<std::uint32_t>(kept.size());
    kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(r.features.count()));
  }
  words_ = std::move(kept);
}

// The margin follows the pace: a stone in flight is checked often whatever is kept, one at rest
// should keep little. The last normal starts GJK, since it has hardly rotated.
void StoneContacts::update_features(const Scene& scene, const StoneList& list, std::uint32_t e,
                                    double path) {
  const PairView pair(scene, list, pieces_[e], e);
  Reach& reach = reaches_[e];
  const double pace = scene.pieces.pace[checks_[e].i] + scene.pieces.pace[checks_[e].j];
  const double slack =
      std::clamp(margin_steps * pace, least_margin * pair.reach, most_margin * pair.reach);
  Vec3 start = reach.normal;
  if (start.isZero()) {
    start = pair.j.offset + pair.j.corners[0].vec3() - pair.i.corners[0].vec3();
    start = start.norm() > 0 ? Vec3(start.normalized()) : Vec3(Vec3::UnitZ());
  }
  // To a tenth of the margin: with a slab that is somewhat too narrow a few features more are kept.
  const Slab slab = widest_slab(pair.i, pair.j, start, 0.1 * slack);
  const bool apart = slab.width > pair.reach + slack;
  reach.normal = slab.normal;
  live_ -= reach.features.count();
  reach.features = {};
  reach.begin = static_cast<std::uint32_t>(words_.size());
  reach.watch = slab.width < close * pair.reach;
  // Separate: nothing is kept, and no check is needed before the gap has closed.
  reach.slack = apart ? slab.width - pair.reach : slack;
  reach.gap = apart ? reach.slack : 0;
  reach.until = path + reach.slack;
  if (!apart)
    reach.features = find_features(pair, reach.normal, pair.reach + slack - slab.width,
                                   pair.reach + slack, words_);
  live_ += reach.features.count();
  poses_[e] = pose(scene, list, checks_[e], e);
}

// Releases the lane until the gap may have closed.
void StoneContacts::release_lane(StoneList& list, std::uint32_t e) {
  if (blocks_.has(e)) blocks_.remove(e, list);
  if (list.entries[e].touching) list.forget(e);
  checks_[e].next = reaches_[e].no_contact;
  Couple& couple = couples_[checks_[e].couple];
  couple.next = std::min(couple.next, checks_[e].next);
}

// Checks an entry whose paths have used up its margin.
void StoneContacts::check_entry(const Scene& scene, StoneList& list, std::uint32_t e) {
  Reach& reach = reaches_[e];
  const double path = scene.pieces.path[checks_[e].i] + scene.pieces.path[checks_[e].j];
  const bool known = reach.slack > 0, old = !(path < reach.until);
  const bool valid = known && (old || reach.gap > 0) && still_valid(scene, list, e, path);
  if (path < reach.no_contact) return release_lane(list, e);
  if (old && !valid) {
    update_features(scene, list, e, path);
    if (blocks_.has(e)) blocks_.remove(e, list);
  }
  if (reach.features.count() == 0 && !reach.watch) {
    reach.no_contact = reach.until;
    return release_lane(list, e);
  }
  checks_[e].next = reach.until;
  if (blocks_.has(e)) return;
  const std::span<const FeatureWord> words(words_.data() + reach.begin, reach.features.count());
  blocks_.insert(scene, list, pieces_[e], e, {words, reach.features.of_i, reach.features.of_j});
  Block& block = blocks_.block_of(e);
  const std::size_t lane = blocks_.slot(e) % lanes;
  block.watched |= static_cast<LaneBits>(reach.watch << lane);
  block.fresh |= static_cast<LaneBits>((old && !valid) << lane);
}

// Particles of several pieces have many entries per pair of particles. The rows of a particle's
// pieces follow each other.
void StoneContacts::find_couples(const StoneList& list) {
  couples_.clear(), entries_of_couples_.clear();
  std::vector<std::uint32_t> own;  // entries of a particle
  for (std::size_t r = 0; r < list.rows.size();) {
    const std::uint32_t i = checks_[list.rows[r].begin].i;
    own.clear();
    for (; r < list.rows.size() && checks_[list.rows[r].begin].i == i; ++r)
      for (std::uint32_t e = list.rows[r].begin; e < list.rows[r].end; ++e) own.push_back(e);
    std::stable_sort(own.begin(), own.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return checks_[a].j < checks_[b].j; });
    for (std::size_t k = 0; k < own.size(); ++k) {
      Check& l = checks_[own[k]];
      if (k == 0 || l.j != checks_[own[k - 1]].j)
        couples_.push_back({-1, i, l.j, static_cast<std::uint32_t>(entries_of_couples_.size())});
      l.couple = static_cast<std::uint32_t>(couples_.size() - 1);
      entries_of_couples_.push_back(own[k]);
    }
  }
  couples_.push_back({0, 0, 0, static_cast<std::uint32_t>(entries_of_couples_.size())});
}

// path: m, of both.
void StoneContacts::check_couple(const Scene& scene, StoneList& list, std::size_t couple,
                                 double path) {
  double next = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = couples_[couple].begin; k < couples_[couple + 1].begin; ++k) {
    const std::uint32_t e = entries_of_couples_[k];
    // Written so that a path that is not a number is checked.
    if (!(path < checks_[e].next)) check_entry(scene, list, e);
    next = std::min(next, checks_[e].next);
  }
  couples_[couple].next = next;
}

// In a bed at rest nearly every couple ends at the comparison.
void StoneContacts::check_all(const Scene& scene, StoneList& list) {
  // At most half of the words are unused, apart from a minimum below which short lists are not
  // compacted.
  if (words_.size() > 2 * live_ + 65536) compact();
  if (scene.state.grown != grown_) blocks_.resize(scene), grown_ = scene.state.grown;
  const double* path = scene.pieces.path.data();
  for (std::size_t c = 0; c + 1 < couples_.size(); ++c) {
    const double both = path[couples_[c].i] + path[couples_[c].j];
    if (!(both < couples_[c].next)) [[unlikely]]
      check_couple(scene, list, c, both);
  }
}

// A pair in a lane that is not in contact. It cannot touch before it has closed the remaining gap.
void StoneContacts::handle_gap(const Scene& scene, StoneList& list, Block& block, std::size_t lane,
                               double closest) {
  const std::uint32_t e = block.entry[lane];
  const bool fresh = block.fresh >> lane & 1;
  Reach& reach = reaches_[e];
  const double gap = closest - block.reach[lane];
  if (list.entries[e].touching) list.forget(e);
  if (reach.watch) return;
  if (fresh) reach.gap = gap;
  const Pieces& pieces = scene.pieces;
  const Check& l = checks_[e];
  const double pace = pieces.pace[l.i] + pieces.pace[l.j];
  if (gap < gap_steps * pace || gap < least_gap * block.reach[lane]) return;
  reach.no_contact = std::min(reach.until, pieces.path[l.i] + pieces.path[l.j] + gap);
  release_lane(list, e);
}

// Cores that are close: any direction with an empty slab shows that they are separate; rarely all
// must be tried. The present normal is nearly always one.
void StoneContacts::check_core_overlap(const Scene& scene, const StoneList& list, Block& block,
                                       std::size_t lane, WrenchLanes& lanes_of_w) {
  const std::uint32_t e = block.entry[lane];
  const auto bit = static_cast<LaneBits>(1u << lane);
  const Wrench w = lanes_of_w.at(lane);
  const PairView pair(scene, list, pieces_[e], e);
  const bool apart = w.M > 0 && slab_width(pair.i, pair.j, w.N.normalized()) > 0;
  const Slab slab = apart ? Slab{} : separating_axis(pair.i, pair.j);
  const bool deep = !apart && !(slab.width > 0);
  const bool watched = deep || w.closest < close * pair.reach;
  reaches_[e].watch = watched;
  block.watched = static_cast<LaneBits>((block.watched & ~bit) | (watched ? bit : 0));
  block.deep = static_cast<LaneBits>((block.deep & ~bit) | (deep ? bit : 0));
  if (!deep) return;
  // Counted: the run continues, but roundings are too small or contacts too soft for the load.
  // Counted by the owner of the first particle, like all sums over pairs.
  if (checks_[e].i < scene.state.own) ++deep_;
  lanes_of_w.set(lane, deep_wrench(pair, slab));
}

// Updates the block after its wrenches: pairs that are watched, in contact or release their lane.
// Data of a pair outside its lane are read only for lanes with a change: they are far away in
// memory.
void StoneContacts::update_block(const Scene& scene, StoneList& list, Block& block,
                                 WrenchLanes& w) {
  const Mask near = w.closest < close * block.reach;
  if (block.watched || any(near)) [[unlikely]]
    for (std::size_t k = 0; k < lanes; ++k)
      if ((block.used >> k & 1) && (near[k] || (block.watched >> k & 1)))
        check_core_overlap(scene, list, block, k, w);
  const Mask touching = w.M > all(0);
  const Mask wide = w.closest - block.reach > least_gap * block.reach;
  const Mask parts = mask_of(block.used) & ~touching & (wide | mask_of(block.fresh));
  const Mask changed = (touching ^ mask_of(block.touching)) | parts;
  if (any(changed)) [[unlikely]]
    for (std::size_t k = 0; k < lanes; ++k) {
      const auto bit = static_cast<LaneBits>(1u << k);
      if (!(block.used & bit) || !changed[k]) continue;
      if (touching[k]) {
        block.touching |= bit, list.entries[block.entry[k]].touching = 1;
      } else {
        block.touching &= static_cast<LaneBits>(~bit);
        handle_gap(scene, list, block, k, w.closest[k]);
      }
    }
  block.fresh = 0;
}

// Pairs in the order of the list, which determines the rounding of sums. Few pairs enter or leave
// in a sub-step, and mostly the same ones: a pair that leaves keeps its place.
void StoneContacts::put_in_order() {
  std::vector<std::uint32_t>& changes = blocks_.changes();
  const std::size_t known = order_.size();
  const auto before = [](const PlaceOfPair& a, const PlaceOfPair& b) { return a.entry < b.entry; };
  std::sort(changes.begin(), changes.end());
  changes.erase(std::unique(changes.begin(), changes.end()), changes.end());
  for (const std::uint32_t e : changes) {
    const PlaceOfPair place{e, blocks_.slot(e), checks_[e].i, checks_[e].j};
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(known);
    const auto at = std::lower_bound(order_.begin(), end, place, before);
    if (at != end && at->entry == e)
      at->slot = place.slot;
    else
      order_.push_back(place);
  }
  std::inplace_merge(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(known),
                     order_.end(), before);
  changes.clear();
}

double StoneContacts::compute_forces(const Scene& scene, double dt, StoneList& list, State& state) {
  check_all(scene, list);
  forces_.resize(std::max(forces_.size(), lanes * blocks_.blocks().size()));
  StoneLaw law(scene, dt, !list.roll.empty(), forces_);
  for (std::size_t n = 0; n < blocks_.blocks().size(); ++n) {
    Block& block = blocks_.blocks()[n];
    if (!block.used) continue;
    blocks_.prefetch(n + 2);
    if (n + 1 < blocks_.blocks().size()) law.prefetch(blocks_.blocks()[n + 1]);
    WrenchLanes w = blocks_.wrenches(block, scene, list);
    update_block(scene, list, block, w);
    law.respond(n, block, w);
  }
  put_in_order();
  add(order_, forces_, state);
  return law.largest_overlap();
}

std::vector<Overlap> StoneContacts::overlaps(const Scene& scene, const StoneList& list) const {
  std::vector<Overlap> found;
  for (const Block& block : blocks_.blocks()) {
    if (!block.touching) continue;
    const WrenchLanes w = blocks_.wrenches(block, scene, list);
    for (std::size_t k = 0; k < lanes; ++k) {
      if (!(block.touching >> k & 1)) continue;
      const std::uint32_t e = block.entry[k];
      found.push_back({e, pieces_[e], w.at(k)});
      if (!(block.deep >> k & 1)) continue;
      const PairView pair(scene, list, pieces_[e], e);
      found.back().wrench = deep_wrench(pair, separating_axis(pair.i, pair.j));
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Overlap& a, const Overlap& b) { return a.entry < b.entry; });
  return found;
}

std::size_t StoneContacts::memory() const {
  return reaches_.capacity() * sizeof(Reach) + poses_.capacity() * sizeof(Pose) +
         keys_.capacity() * sizeof(Key) + words_.capacity() * sizeof(FeatureWord) +
         checks_.capacity() * sizeof(Check) + pieces_.capacity() * sizeof(pieces_[0]) +
         couples_.capacity() * sizeof(Couple) +
         entries_of_couples_.capacity() * sizeof(entries_of_couples_[0]) +
         order_.capacity() * sizeof(order_[0]) + forces_.capacity() * sizeof(PairForce) +
         blocks_.memory();
}

}  // namespace trackbed::dem
