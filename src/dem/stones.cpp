// From neighbour list to overlaps: which pairs are looked at (`find`), which features of them
// (`refresh`, `keep_features`), their smooth maximum (`flush`), and the rare overlap of cores
// (`wrench`, `deep_wrench`). Why a smooth maximum: docs/decisions/stone-contact.md.
#include "stones.hpp"

#include <algorithm>
#include <cmath>

#include "deep.hpp"

namespace trackbed::dem {

namespace {

// Distance a pair may close before its features are found anew: what it goes in so many sub-steps
// at its present pace (finding costs many times a sub-step), within these shares of the sum of
// its radii. The fewer features lie within the margin, the less each sub-step has to compute.
constexpr double margin_steps = 100, least_margin = 0.02, most_margin = 0.15;
// Cores nearer than this share of the sum of radii are watched for overlap. A sub-step's motion is
// a small part of it.
constexpr double close = 0.05;
// Cores that overlap are felt as if they were this far apart, over the sum of radii: near enough to
// touching that the energy does not jump, far enough that every normal is known.
constexpr double apart_by = 1e-3;
// Below this share of it a margin counts as used up: what is left would be asked after at once.
constexpr double used_up = 0.1;
constexpr std::size_t block = 256;  // features computed together: stays in the first-level cache

}  // namespace

// One pair, placed: everything relative to the centre of the first one's particle.
struct StoneContacts::Sight {
  Placed i, j;
  double reach;  // m

  Sight(const Scene& scene, const StoneList& list, std::int32_t p, std::uint32_t e) {
    const Entry& other = list.entries[e];
    const auto bi = body(scene, p), bj = body(scene, other.piece);
    const Vec4 &xi = scene.state.x[bi], &xj = scene.state.x[bj], &h = list.shifts[other.shift];
    i = placed(scene, p, bi, Vec3::Zero());
    j = placed(scene, other.piece, bj, {xj.x - xi.x + h.x, xj.y - xi.y + h.y, xj.z - xi.z + h.z});
    reach = i.radius + j.radius;
  }
  static std::size_t body(const Scene& scene, std::int32_t piece) {
    return static_cast<std::size_t>(scene.pieces.body[static_cast<std::size_t>(piece)]);
  }
  // Corners are a view into `pieces`, good until these are laid out anew.
  static Placed placed(const Scene& scene, std::int32_t piece, std::size_t b, const Vec3& offset) {
    const auto p = static_cast<std::size_t>(piece);
    const Pieces& all = scene.pieces;
    const std::size_t k = scene.shapes.begin(scene.state.shape[b]) + p - all.begin[b];
    const std::span corners(all.corners);
    return {&scene.shapes.core(k),
            corners.subspan(all.first_corner[p], all.first_corner[p + 1] - all.first_corner[p]),
            offset, all.rounding[p]};
  }
};

namespace {

// Corners of a core that reach further along `direction` than `least` m, and the edges and
// triangles they belong to.
// An edge or a triangle may reach into the slab only if one of its corners does.
struct Near {
  std::vector<std::uint8_t> corners;
  std::vector<std::uint16_t> edges, triangles;

  void find(const Placed& core, const Vec3& direction, double least) {
    corners.clear(), edges.clear(), triangles.clear();
    std::array<bool, most_corners + 1> in{};
    for (std::size_t k = 0; k < core.corners.size(); ++k)
      if ((in[k] = direction.dot(core.corner(k)) >= least))
        corners.push_back(static_cast<std::uint8_t>(k));
    const auto collect = [&](const auto& features, std::vector<std::uint16_t>& kept) {
      for (std::size_t k = 0; k < features.size(); ++k)
        if (std::any_of(features[k].begin(), features[k].end(), [&](auto c) { return in[c]; }))
          kept.push_back(static_cast<std::uint16_t>(k));
    };
    collect(core.core->edges, edges);
    collect(core.core->triangles, triangles);
  }
};

[[gnu::always_inline]] inline Vec4 point(const Placed& core, std::uint8_t corner) {
  const Vec4& c = core.corners[corner];
  return {c.x + core.offset.x(), c.y + core.offset.y(), c.z + core.offset.z(), 0};
}

[[gnu::always_inline]] inline void add_corner(FeatureRow& row, const Placed& i, const Placed& j,
                                              const FeatureWord& w, bool of_i) {
  const Placed &own = of_i ? i : j, &other = of_i ? j : i;
  row.add(of_i ? 1 : -1, i.radius, j.radius,
          {point(own, w[0]), point(other, w[1]), point(other, w[2]), point(other, w[3])});
}

[[gnu::always_inline]] inline void add_edges(FeatureRow& row, const Placed& i, const Placed& j,
                                             const FeatureWord& w) {
  row.add(1, i.radius, j.radius, {point(i, w[0]), point(i, w[1]), point(j, w[2]), point(j, w[3])});
}

double furthest_along(const Placed& core, const Vec3& direction) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < core.corners.size(); ++k)
    most = std::max(most, direction.dot(core.corner(k)));
  return most;
}

}  // namespace

StoneContacts::Pose StoneContacts::pose(const Scene& scene, const StoneList& list, std::int32_t p,
                                        const Entry& other) {
  const auto i = Sight::body(scene, p), j = Sight::body(scene, other.piece);
  const State& s = scene.state;
  const Quat back = quat(s.q[i]).conjugate(), q = back * quat(s.q[j]);
  const Vec3 x = back * (s.x[j].vec3() - s.x[i].vec3() + list.shifts[other.shift].vec3());
  return {{static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())},
          {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
           static_cast<float>(q.w())},
          static_cast<float>(s.x[i].w + s.x[j].w)};
}

// By how much two surface points can have come closer at most, m, with r the radius of the ball
// around j: the way of its centre and the arc of its farthest point seen from i, and growth. What
// both do together is not in it, nor ways that went back. Roundings are those of `float`.
double StoneContacts::closed(const Pose& a, const Pose& b, double r) {
  double way = 0, turn = 0, far = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = static_cast<double>(b.x[k]) - static_cast<double>(a.x[k]);
    way += d * d, far += std::abs(static_cast<double>(b.x[k]));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const double d = static_cast<double>(b.q[k]) - static_cast<double>(a.q[k]);
    turn += d * d;
  }
  constexpr double rounding = 1e-6;  // several units in the last place of each number
  const double grown = static_cast<double>(b.size) - static_cast<double>(a.size);
  return std::sqrt(way) + 2.1 * r * std::sqrt(turn) + std::abs(grown) +
         rounding * (far + static_cast<double>(b.size));
}

// Both paths together are only a bound, and a poor one where stones move with each other or to and
// fro, as in a bed that is pressed or shaken. So when they have used up a margin, the pose tells
// how much of it is left, for a fraction of what finding features anew costs.
bool StoneContacts::still_good(const Scene& scene, const StoneList& list, std::int32_t p,
                               std::uint32_t e, double path) {
  Reach& reach = reaches_[e];
  const Entry& other = list.entries[e];
  const double r = scene.state.x[Sight::body(scene, other.piece)].w;
  const double used = closed(poses_[e], pose(scene, list, p, other), r);
  const double left = reach.slack - used, quiet = reach.gap - used;
  // A gap that is used up is not asked after again: distances tell from now on.
  if (!(quiet > used_up * reach.gap)) reach.gap = 0;
  if (!(left > used_up * reach.slack)) return false;
  reach.until = std::max(reach.until, path + left);
  if (reach.gap > 0) reach.quiet = std::min(reach.until, path + quiet);
  return true;
}

// Numbers of entries, pieces and bodies have changed and paths begin at 0; what a pair keeps names
// corners of its cores only. Lists ascend by both keys, so one pass over old and new finds who was
// there before. In a bed that moves lists get old every 20 sub-steps, features seldom.
void StoneContacts::reset(const Scene& scene, const StoneList& list) {
  const auto key = [&](std::int32_t piece) {
    const std::size_t b = Sight::body(scene, piece);
    return piece_key(scene.state.id[b], static_cast<std::size_t>(piece) - scene.pieces.begin[b]);
  };
  std::vector<Reach> reaches(list.entries.size());
  std::vector<Pose> poses(list.entries.size());
  std::vector<Key> keys;
  keys.reserve(list.entries.size());
  std::size_t old = 0;
  for (const Row& row : list.rows)
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const Key wanted = keys.emplace_back(key(row.piece), key(list.entries[e].piece));
      while (old < keys_.size() && keys_[old] < wanted) ++old;
      if (old == keys_.size() || keys_[old] != wanted) continue;
      reaches[e] = reaches_[old], poses[e] = poses_[old];
      reaches[e].until = reaches[e].quiet = -1;
      ++old;  // a partner met twice, across a periodic side: the second is not the first
    }
  reaches_.swap(reaches), poses_.swap(poses), keys_.swap(keys);
  compact();
  live_ = words_.size();
  found_.clear();
}

// Drops the words of pairs that have found new ones.
// Words are appended and never overwritten, as pairs find more or fewer features each time.
void StoneContacts::compact() {
  std::vector<FeatureWord> kept;
  kept.reserve(words_.size());
  for (Reach& r : reaches_) {
    const auto from = words_.begin() + r.begin;
    r.begin = static_cast<std::uint32_t>(kept.size());
    kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(r.count()));
  }
  words_ = std::move(kept);
}

// Every feature whose distance can become smaller than `within` passes the slab test; of those the
// ones that are that near now are kept. Order: corners of i, of j, edges, each ascending.
void StoneContacts::keep_features(const Sight& sight, Reach& reach, double depth, double within) {
  // Kept for their memory only.
  thread_local Near of_i, of_j;
  thread_local FeatureRow corners, edges;
  thread_local std::vector<FeatureWord> words;
  const Vec3 n = reach.normal;
  // What lies deeper than `depth` behind the foremost corner is further from the other core than
  // `within`, for the empty slab lies between.
  of_i.find(sight.i, n, furthest_along(sight.i, n) - depth);
  of_j.find(sight.j, -n, furthest_along(sight.j, -n) - depth);
  corners.clear(), edges.clear(), words.clear();
  const auto corner_words = [&](const Near& own, const Near& other, const Core& core, bool first) {
    for (const std::uint8_t c : own.corners)
      for (const std::uint16_t t : other.triangles) {
        const Core::Triangle& triangle = core.triangles[t];
        words.push_back({c, triangle[0], triangle[1], triangle[2]});
        add_corner(corners, sight.i, sight.j, words.back(), first);
      }
  };
  // All triangles of one corner follow each other: `smooth_maximum` counts on it.
  corner_words(of_i, of_j, *sight.j.core, true);
  const std::size_t first_of_j = words.size();
  corner_words(of_j, of_i, *sight.i.core, false);
  const std::size_t first_edge = words.size();
  // Flat cores in one plane meet with corners only; their crossed edges would count those twice.
  if (!(sight.i.core->flat && sight.j.core->flat))
    for (const std::uint16_t e : of_i.edges)
      for (const std::uint16_t f : of_j.edges) {
        const Core::Edge &a = sight.i.core->edges[e], &b = sight.j.core->edges[f];
        words.push_back({a[0], a[1], b[0], b[1]});
        add_edges(edges, sight.i, sight.j, words.back());
      }
  corners.compute_corners(), edges.compute_edges();
  for (std::size_t k = 0; k < words.size(); ++k) {
    const bool edge = k >= first_edge;
    if ((edge ? edges.distance(k - first_edge) : corners.distance(k)) > within) continue;
    words_.push_back(words[k]);
    ++(edge ? reach.edges : (k < first_of_j ? reach.of_i : reach.of_j));
  }
}

// The margin follows the pace: a stone that flies is looked at often whatever is kept, one that
// rests should keep little. The last normal starts GJK, since it has hardly turned.
void StoneContacts::refresh(const Sight& sight, Reach& reach, double path, double pace) {
  const double slack =
      std::clamp(margin_steps * pace, least_margin * sight.reach, most_margin * sight.reach);
  Vec3 start = reach.normal;
  if (start.isZero()) {
    start = sight.j.offset + sight.j.corners[0].vec3() - sight.i.corners[0].vec3();
    start = start.norm() > 0 ? Vec3(start.normalized()) : Vec3(Vec3::UnitZ());
  }
  // To a tenth of the margin: a slab somewhat too narrow keeps a few features more.
  const Slab slab = widest_slab(sight.i, sight.j, start, 0.1 * slack);
  const bool apart = slab.width > sight.reach + slack;
  reach.normal = slab.normal;
  live_ -= reach.count();
  reach.of_i = reach.of_j = reach.edges = 0;
  reach.begin = static_cast<std::uint32_t>(words_.size());
  reach.watch = slab.width < close * sight.reach;
  // Apart: nothing is kept, and nothing is to be looked at before the gap has closed.
  reach.slack = apart ? slab.width - sight.reach : slack;
  reach.gap = apart ? reach.slack : 0;
  reach.until = path + reach.slack;
  if (!apart) keep_features(sight, reach, sight.reach + slack - slab.width, sight.reach + slack);
  live_ += reach.count();
}

FeatureSet StoneContacts::gather(const Sight& sight, const Reach& reach, FeatureRow& corners,
                                 FeatureRow& edges) const {
  const FeatureWord* word = words_.data() + reach.begin;
  FeatureSet set{corners.size(), 0, edges.size(), 0, reach.begin, reach.of_i};
  for (std::size_t k = 0; k < static_cast<std::size_t>(reach.of_i) + reach.of_j; ++k)
    add_corner(corners, sight.i, sight.j, *word++, k < reach.of_i);
  for (std::size_t k = 0; k < reach.edges; ++k) add_edges(edges, sight.i, sight.j, *word++);
  set.corners_end = corners.size(), set.edges_end = edges.size();
  return set;
}

// What is felt when j is moved out along a way, its cores then apart.
// Words are borrowed at the end of the list and given back.
Wrench StoneContacts::moved_wrench(const Sight& sight, const Vec3& n, double length) {
  thread_local FeatureRow corners, edges;
  corners.clear(), edges.clear();
  Sight moved = sight;
  moved.j.offset += length * n;
  Reach near;
  near.normal = n;
  near.begin = static_cast<std::uint32_t>(words_.size());
  keep_features(moved, near, sight.reach, sight.reach);
  const FeatureSet set = gather(moved, near, corners, edges);
  corners.compute_corners(), edges.compute_edges();
  const Wrench w = smooth_maximum(corners, edges, set, words_.data(), sight.reach);
  words_.resize(near.begin);
  return w;
}

// Ways up to `longest` times the shortest: apart - width is the length of a way, so their slabs
// have at least the width apart - longest * shortest. What touches there has the overlap reach -
// apart.
Wrench StoneContacts::deep_wrench(const Sight& sight, const Slab& widest) {
  thread_local std::vector<WayOut> ways;
  const double apart = apart_by * sight.reach, shortest = apart - widest.width;
  ways_out(sight.i, sight.j, apart - DeepBlend::longest * shortest, ways);
  DeepBlend blend(sight.reach - apart);
  for (const WayOut& way : ways) {
    const double length = apart - way.slab.width;
    blend.add(way, length, shortest, moved_wrench(sight, way.slab.normal, length));
  }
  return blend.result();
}

Wrench StoneContacts::wrench(const Scene& scene, const StoneList& list, const Pending& p) {
  Reach& reach = reaches_[p.entry];
  const Wrench w = smooth_maximum(corners_, edges_, p.set, words_.data(), p.reach);
  if (w.closest < close * p.reach) reach.watch = true;
  if (!reach.watch) return w;
  const Sight sight(scene, list, p.piece, p.entry);
  // Any direction with an empty slab shows that the cores are apart; seldom all must be tried.
  // The normal of what is felt is nearly always one.
  const bool apart = w.M > 0 && slab_width(sight.i, sight.j, w.N.normalized()) > 0;
  const Slab slab = apart ? Slab{} : separating_axis(sight.i, sight.j);
  if (apart || slab.width > 0) {
    reach.watch = w.closest < close * sight.reach;
    return w;
  }
  // Counted: the run goes on, but roundings are too small or contacts too soft for what is asked.
  // By the owner of the first, as all sums over pairs.
  if (Sight::body(scene, p.piece) < scene.state.own) ++deep_;
  return deep_wrench(sight, slab);
}

// In the order of the list, on which the bits of sums rest.
void StoneContacts::flush(const Scene& scene, StoneList& list) {
  corners_.compute_corners(), edges_.compute_edges();
  for (const Pending& p : pending_) {
    const Wrench w = wrench(scene, list, p);
    Entry& entry = list.entries[p.entry];
    if (w.M > 0) {
      entry.touching = 1;
      found_.push_back({p.entry, p.piece, w});
      continue;
    }
    // Nothing can touch before the pair has closed the gap that is left.
    Reach& reach = reaches_[p.entry];
    if (!reach.watch) reach.quiet = std::min(reach.until, p.path + (w.closest - p.reach));
    if (!reach.watch && p.fresh) reach.gap = w.closest - p.reach;
    if (entry.touching) list.forget(p.entry);
  }
  pending_.clear(), corners_.clear(), edges_.clear();
}

// Local. In a bed at rest most pairs end at the first question: their paths have not used up what
// separates them.
const std::vector<Overlap>& StoneContacts::find(const Scene& scene, StoneList& list) {
  found_.clear();
  // Half of it rubbish at most, beside a floor that spares short lists the trouble.
  if (words_.size() > 2 * live_ + 65536) compact();
  for (const Row& row : list.rows) {
    const Pieces& pieces = scene.pieces;
    const std::size_t i = Sight::body(scene, row.piece);
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      Reach& reach = reaches_[e];
      const std::size_t j = Sight::body(scene, list.entries[e].piece);
      const double path = pieces.path[i] + pieces.path[j];
      if (path < reach.quiet) continue;
      const bool known = reach.slack > 0, old = !(path < reach.until);
      const bool good =
          known && (old || reach.gap > 0) && still_good(scene, list, row.piece, e, path);
      if (path < reach.quiet) continue;
      const Sight sight(scene, list, row.piece, e);
      const bool fresh = old && !good;
      if (fresh) {
        refresh(sight, reach, path, pieces.pace[i] + pieces.pace[j]);
        poses_[e] = pose(scene, list, row.piece, list.entries[e]);
      }
      const FeatureSet set = gather(sight, reach, corners_, edges_);
      pending_.push_back({e, row.piece, set, sight.reach, path, fresh});
      if (corners_.size() > block || edges_.size() > block) flush(scene, list);
    }
  }
  flush(scene, list);
  return found_;
}

std::size_t StoneContacts::memory() const {
  return reaches_.capacity() * sizeof(Reach) + poses_.capacity() * sizeof(Pose) +
         keys_.capacity() * sizeof(Key) + words_.capacity() * sizeof(FeatureWord) +
         found_.capacity() * sizeof(Overlap);
}

}  // namespace trackbed::dem
