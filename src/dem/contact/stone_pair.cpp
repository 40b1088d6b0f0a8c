#include "dem/contact/stone_pair.hpp"

#include <algorithm>
#include <limits>

#include "dem/shape/deep.hpp"

namespace trackbed::dem {

namespace {

// Cores that overlap are evaluated as if they were this far apart, over the sum of radii: close
// enough to contact that the energy is continuous, far enough that every normal is defined.
constexpr double apart_by = 1e-3;

// Corners of a core that reach further along `direction` than `least` m, and the edges and
// triangles they belong to. An edge or a triangle may reach into the slab only if one of its
// corners does.
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

Vec4 point(const Placed& core, std::uint8_t corner) {
  const Vec4& c = core.corners[corner];
  return {c.x + core.offset.x(), c.y + core.offset.y(), c.z + core.offset.z(), 0};
}

void add_corner(FeatureRow& row, const PlacedPair& s, const FeatureWord& w, bool of_i) {
  const Placed &own = of_i ? s.i : s.j, &other = of_i ? s.j : s.i;
  row.add(of_i ? 1 : -1, s.i.radius, s.j.radius,
          {point(own, w[0]), point(other, w[1]), point(other, w[2]), point(other, w[3])});
}

void add_edges(FeatureRow& row, const PlacedPair& s, const FeatureWord& w) {
  row.add(1, s.i.radius, s.j.radius,
          {point(s.i, w[0]), point(s.i, w[1]), point(s.j, w[2]), point(s.j, w[3])});
}

double furthest_along(const Placed& core, const Vec3& direction) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < core.corners.size(); ++k)
    most = std::max(most, direction.dot(core.corner(k)));
  return most;
}

// The wrench when j is displaced along n and the cores are separate.
Wrench displaced_wrench(const PlacedPair& pair, const Vec3& n, double length) {
  thread_local FeatureRow corners, edges;
  thread_local std::vector<FeatureWord> words;
  corners.clear(), edges.clear(), words.clear();
  PlacedPair displaced = pair;
  displaced.j.offset += length * n;
  const FeatureCounts near = find_features(displaced, n, pair.reach, pair.reach, words);
  const std::size_t of_corners = static_cast<std::size_t>(near.of_i) + near.of_j;
  for (std::size_t k = 0; k < words.size(); ++k)
    if (k < of_corners)
      add_corner(corners, displaced, words[k], k < near.of_i);
    else
      add_edges(edges, displaced, words[k]);
  corners.compute_corners(), edges.compute_edges();
  const FeatureSet set{0, corners.size(), 0, edges.size(), 0, near.of_i};
  return smooth_maximum(corners, edges, set, words.data(), pair.reach);
}

}  // namespace

PairView::PairView(const Scene& scene, const StoneList& list, std::int32_t piece,
                   std::uint32_t entry) {
  const Entry& other = list.entries[entry];
  const auto body = [&](std::int32_t p) {
    return static_cast<std::size_t>(scene.pieces.body[static_cast<std::size_t>(p)]);
  };
  const std::size_t bi = body(piece), bj = body(other.piece);
  const Vec4 &xi = scene.state.x[bi], &xj = scene.state.x[bj], &h = list.shifts[other.shift];
  const auto p = static_cast<std::size_t>(piece), q = static_cast<std::size_t>(other.piece);
  append_corners(scene.shapes, scene.pieces, p, corners_);
  const std::size_t of_i = corners_.size();
  append_corners(scene.shapes, scene.pieces, q, corners_);
  const auto placed = [&](std::size_t k, std::span<const Vec4> corners, const Vec3& offset) {
    return Placed{&scene.shapes.core(scene.pieces.core[k]), corners, offset,
                  scene.pieces.rounding[k]};
  };
  const std::span<const Vec4> all(corners_);
  i = placed(p, all.first(of_i), Vec3::Zero());
  j = placed(q, all.subspan(of_i), {xj.x - xi.x + h.x, xj.y - xi.y + h.y, xj.z - xi.z + h.z});
  reach = i.radius + j.radius;
}

FeatureCounts find_features(const PlacedPair& pair, const Vec3& normal, double depth, double within,
                            std::vector<FeatureWord>& words) {
  // Kept for their memory only.
  thread_local Near of_i, of_j;
  thread_local FeatureRow corners, edges;
  thread_local std::vector<FeatureWord> candidates;
  // Features deeper than `depth` behind the foremost corner are further from the other core than
  // `within`, because the empty slab is between them.
  of_i.find(pair.i, normal, furthest_along(pair.i, normal) - depth);
  of_j.find(pair.j, -normal, furthest_along(pair.j, -normal) - depth);
  corners.clear(), edges.clear(), candidates.clear();
  const auto corner_words = [&](const Near& own, const Near& other, const Core& core, bool first) {
    for (const std::uint8_t c : own.corners)
      for (const std::uint16_t t : other.triangles) {
        const Core::Triangle& triangle = core.triangles[t];
        candidates.push_back({c, triangle[0], triangle[1], triangle[2]});
        add_corner(corners, pair, candidates.back(), first);
      }
  };
  corner_words(of_i, of_j, *pair.j.core, true);
  const std::size_t first_of_j = candidates.size();
  corner_words(of_j, of_i, *pair.i.core, false);
  const std::size_t first_edge = candidates.size();
  // Flat cores in one plane are in contact with corners only; their crossed edges would count those
  // twice.
  if (!(pair.i.core->flat && pair.j.core->flat))
    for (const std::uint16_t e : of_i.edges)
      for (const std::uint16_t f : of_j.edges) {
        const Core::Edge &a = pair.i.core->edges[e], &b = pair.j.core->edges[f];
        candidates.push_back({a[0], a[1], b[0], b[1]});
        add_edges(edges, pair, candidates.back());
      }
  corners.compute_corners(), edges.compute_edges();
  FeatureCounts kept;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const bool edge = k >= first_edge;
    if ((edge ? edges.distance(k - first_edge) : corners.distance(k)) > within) continue;
    words.push_back(candidates[k]);
    ++(edge ? kept.edges : (k < first_of_j ? kept.of_i : kept.of_j));
  }
  return kept;
}

// j is displaced along directions up to `longest` times the shortest: apart - width is the length
// of a displacement, so their slabs have at least the width apart - longest * shortest. The overlap
// there is reach - apart.
Wrench deep_wrench(const PlacedPair& pair, const Slab& widest) {
  thread_local std::vector<SeparationDirection> directions;
  const double apart = apart_by * pair.reach, shortest = apart - widest.width;
  separation_directions(pair.i, pair.j, apart - DeepBlend::longest * shortest, directions);
  DeepBlend blend(pair.reach - apart);
  for (const SeparationDirection& direction : directions) {
    const double length = apart - direction.slab.width;
    blend.add(direction, length, shortest, displaced_wrench(pair, direction.slab.normal, length));
  }
  return blend.result();
}

}  // namespace trackbed::dem
