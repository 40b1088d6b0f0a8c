// Two parts: `Finder` selects, from time to time, the features that may come within contact before
// the margin is used up; `touch_surface` computes distances of the selected ones in each sub-step.
// Both use the same functions for a distance, so their results agree.
#include "dem/shape/stone_surface.hpp"

#include <algorithm>
#include <cmath>

#include "dem/shape/features.hpp"

namespace trackbed::dem {

namespace {

// Path for which selected features are valid, m: that of both bodies in this number of sub-steps at
// their present pace, within these fractions of the rounding. A wide margin keeps more features for
// each sub-step, a narrow one requires more searches, which cost as much as several sub-steps.
constexpr double margin_steps = 400, least_margin = 0.05, most_margin = 0.5;

// Has an inside: only then a point or an edge can be in it, and distances have a sign.
bool solid(const Core& core) { return !core.flat && core.corners.size() > 3; }

// Closest points of an edge of the piece and a sharp edge, or of a triangle of the piece and a
// sharp corner, computed in rows. Radii are given as 0: the rows' own overlaps are not used, only
// distance, normal and point.
class Rows {
 public:
  void clear() { edges_.clear(), corners_.clear(); }
  void add_edges(const StoneView& s, std::uint16_t own, int part) {
    const Core::Edge& e = s.stone.core->edges[own];
    const auto& nodes = s.mesh.edge(part).nodes;
    edges_.add(1, 0, 0,
               {vec4(s.stone.corner(e[0])), vec4(s.stone.corner(e[1])), vec4(s.node(nodes[0])),
                vec4(s.node(nodes[1]))});
  }
  void add_corner(const StoneView& s, std::uint16_t own, int part) {
    const Core::Triangle& t = s.stone.core->triangles[own];
    corners_.add(-1, 0, 0,
                 {vec4(s.node(s.mesh.corner(part).node)), vec4(s.stone.corner(t[0])),
                  vec4(s.stone.corner(t[1])), vec4(s.stone.corner(t[2]))});
  }
  void compute() { edges_.compute_edges(), corners_.compute_corners(); }
  const FeatureRow& of(FeatureKind kind) const {
    return kind == FeatureKind::edge ? edges_ : corners_;
  }

 private:
  FeatureRow edges_, corners_;
};

// Whether n is between the normals p and q of the two faces of an edge (all across the edge). p, q
// and n need no unit length: only signs are evaluated.
bool between(const Vec3& n, const Vec3& p, const Vec3& q) {
  const Vec3 turn = p.cross(q);
  return p.cross(n).dot(turn) > 0 && n.cross(q).dot(turn) > 0;
}

Vec3 normal_of(const Placed& stone, const Core::Triangle& t) {
  const Vec3 a = stone.corner(t[0]);
  return (stone.corner(t[1]) - a).cross(stone.corner(t[2]) - a);
}

Vec3 normal_of(const StoneView& s, int triangle) {
  const auto& n = s.surface.triangles[static_cast<std::size_t>(triangle)];
  const Vec3 a = s.node(n[0]);
  return (s.node(n[1]) - a).cross(s.node(n[2]) - a);
}

// Two edges that have passed through each other: the vector from one to the other points into both
// bodies, as follows from the normals of their faces (arcs on the Gauss sphere, as in the
// separating axis test of edges). Without this test a stone that penetrates the edge of a sleeper
// would be drawn further in. When the edges pass the distance is zero, so its sign may change
// without a jump.
// jump.
bool crossed(const StoneView& s, const Core::Edge& e, const SharpEdge& f, const Vec3& n) {
  if (!solid(*s.stone.core) || f.triangles[1] < 0) return false;
  constexpr double across = 1e-6;  // the closest points are within both edges
  const Vec3 u = s.stone.corner(e[1]) - s.stone.corner(e[0]),
             w = s.node(f.nodes[1]) - s.node(f.nodes[0]);
  // Beside an end the corner decides, not the edge.
  if (std::abs(n.dot(u)) > across * u.norm() || std::abs(n.dot(w)) > across * w.norm())
    return false;
  if (!between(n, normal_of(s, f.triangles[0]), normal_of(s, f.triangles[1]))) return false;
  Vec3 normals[2];
  int count = 0;
  for (const Core::Triangle& t : s.stone.core->triangles) {
    const auto has = [&](std::uint8_t c) { return t[0] == c || t[1] == c || t[2] == c; };
    if (has(e[0]) && has(e[1]) && count < 2) normals[count++] = normal_of(s.stone, t);
  }
  return count == 2 && between(-n, normals[0], normals[1]);
}

// The plane of the piece below which a point inside is least deep: normal and height (negative), or
// a positive height if the point is outside. Minus the height is the distance to the outside
// through the nearest face, i.e. the penetration of a sharp corner of the surface.
Slab below_faces(const Placed& stone, const Vec3& p) {
  Slab nearest{Vec3::Zero(), -1e300};
  for (const Core::Triangle& t : stone.core->triangles) {
    const Vec3 n = normal_of(stone, t).normalized();
    const double height = n.dot(p - stone.corner(t[0]));
    if (height > nearest.width) nearest = {n, height};
    if (height > 0) break;
  }
  return nearest;
}

// Weights of the nodes of a triangle at a point of its side, or at one node.
Vec3 weight_at(const StoneView& s, int triangle, const SharpEdge& edge, const Vec3& point) {
  const Vec3 a = s.node(edge.nodes[0]), ab = s.node(edge.nodes[1]) - a;
  const double t = std::clamp((point - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  const auto& nodes = s.surface.triangles[static_cast<std::size_t>(triangle)];
  Vec3 weight = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    weight[static_cast<int>(k)] =
        nodes[k] == edge.nodes[0] ? 1 - t : (nodes[k] == edge.nodes[1] ? t : 0.0);
  return weight;
}

// `row.contact` is at half the distance from i's edge along the normal: another half leads to the
// surface.
MeshContact edge_contact(const StoneView& s, const SurfaceFeature& f, const FeatureRow& row,
                         std::size_t slot) {
  const SharpEdge& edge = s.mesh.edge(f.part);
  MeshContact c;
  c.triangle = edge.triangles[0], c.patch = f.patch;
  c.distance = row.distance(slot), c.normal = row.normal(slot);
  c.point = row.contact(slot) + 0.5 * c.distance * c.normal;
  // The first triangle of the edge takes the force, on the two nodes that both triangles share.
  c.weight = weight_at(s, c.triangle, edge, c.point);
  if (crossed(s, s.stone.core->edges[f.own], edge, c.normal))
    c.distance = -c.distance, c.normal = -c.normal;
  return c;
}

MeshContact corner_contact(const StoneView& s, const SurfaceFeature& f, const FeatureRow& row,
                           std::size_t slot) {
  const SharpCorner& corner = s.mesh.corner(f.part);
  MeshContact c;
  c.triangle = corner.triangle, c.patch = f.patch;
  c.distance = row.distance(slot), c.normal = row.normal(slot);
  c.point = s.node(corner.node);
  const auto& nodes = s.surface.triangles[static_cast<std::size_t>(c.triangle)];
  for (std::size_t k = 0; k < 3; ++k) c.weight[static_cast<int>(k)] = nodes[k] == corner.node;
  if (!solid(*s.stone.core)) return c;
  const Slab inside = below_faces(s.stone, c.point);
  // Continuous: on the piece's face both distances are zero.
  if (inside.width <= 0) c.distance = inside.width, c.normal = inside.normal;
  return c;
}

// Collects the features that `find_features` keeps.
class Finder {
 public:
  Finder(const StoneView& view, const std::vector<int>& triangles, double slack, NearFeatures& near)
      : s_(view), triangles_(triangles), near_(near), slack_(slack) {}

  void run(double path) {
    near_.features.clear();
    for (std::size_t c = 0; c < s_.stone.corners.size(); ++c) corner(static_cast<std::uint16_t>(c));
    // Rows are computed together, so candidates of all edges and corners are listed first.
    rows_.clear(), candidates_.clear();
    for (const int t : triangles_) {
      for (const int e : s_.mesh.edges_of(t)) sharp_edge(t, e);
      for (const int c : s_.mesh.corners_of(t)) sharp_corner(t, c);
    }
    rows_.compute();
    keep_rows();
    std::sort(near_.features.begin(), near_.features.end());
    // At least the slack; further if even the nearest feature that is left out is further away. A
    // kept feature that is near excludes this (least_ = 0).
    near_.until = path + std::max(slack_, least_);
  }

 private:
  // Gap of a feature that is not kept: it need not be considered before the gap has closed. Gaps
  // decrease no faster than paths grow.
  void left_out(double gap) { least_ = std::min(least_, gap); }
  bool keeps(double gap) const { return gap < slack_; }

  // Triangles that may contain the closest point of a patch while it is near: those within twice
  // the slack of the closest, as both distances change by no more than the paths do.
  void corner(std::uint16_t c) {
    const double radius = s_.stone.radius;
    const Vec3 p = s_.stone.corner(c);
    // The closest triangle of each patch, chosen as in `touch_surface`.
    all_.clear(), best_.clear();
    for (const int t : triangles_) {
      all_.push_back(s_.mesh.closest(p, t, s_.surface, s_.fraction, s_.origin));
      auto same = std::find_if(best_.begin(), best_.end(), [&](const Closest& b) {
        return b.contact.patch == all_.back().contact.patch;
      });
      if (same == best_.end())
        best_.push_back(all_.back());
      else if (all_.back().replaces(*same, 1e-12 * radius * radius))
        *same = all_.back();
    }
    for (Closest& b : best_) {
      const double nearest = std::sqrt(b.squared);
      const bool sided = s_.mesh.determine_side(b, p, s_.surface, s_.fraction, s_.origin);
      if (sided && !keeps(b.contact.distance - radius)) {
        left_out(b.contact.distance - radius);
        continue;
      }
      least_ = 0;
      // Points that are behind, or may get there around an open edge, may be deep: any triangle may
      // count.
      const double within = sided && b.contact.distance > 0 ? nearest + 2 * slack_ : 1e150;
      for (const Closest& other : all_)
        if (other.contact.patch == b.contact.patch && other.squared <= within * within)
          near_.features.push_back(
              {b.contact.patch, FeatureKind::corner, c, -1, other.contact.triangle, c});
    }
  }

  // The ball around the piece is tested first; a stone is rarely near an edge at all.
  void sharp_edge(int triangle, int e) {
    const auto& nodes = s_.mesh.edge(e).nodes;
    const Vec3 a = s_.node(nodes[0]), b = s_.node(nodes[1]);
    const Vec3 w = closest_weights(s_.ball.centre, a, b, b);
    const double gap = (w[0] * a + (w[1] + w[2]) * b - s_.ball.centre).norm() - s_.ball.radius;
    if (!keeps(gap)) return left_out(gap);
    for (std::size_t own = 0; own < s_.stone.core->edges.size(); ++own) {
      const auto k = static_cast<std::uint16_t>(own);
      rows_.add_edges(s_, k, e);
      candidates_.push_back(
          {s_.mesh.patch(triangle), FeatureKind::edge, k, s_.mesh.edge(e).chain, e, k});
    }
  }

  void sharp_corner(int triangle, int c) {
    const double gap = (s_.node(s_.mesh.corner(c).node) - s_.ball.centre).norm() - s_.ball.radius;
    if (!keeps(gap)) return left_out(gap);
    for (std::size_t own = 0; own < s_.stone.core->triangles.size(); ++own) {
      const auto k = static_cast<std::uint16_t>(own);
      rows_.add_corner(s_, k, c);
      candidates_.push_back({s_.mesh.patch(triangle), FeatureKind::sharp_corner, 0, c, c, k});
    }
  }

  void keep_rows() {
    const double radius = s_.stone.radius;
    std::array<std::size_t, 3> slot{};
    // Position of each candidate in the row of its kind.
    std::vector<std::size_t> slots;
    for (const SurfaceFeature& f : candidates_)
      slots.push_back(slot[static_cast<std::size_t>(f.kind)]++);
    for (std::size_t k = 0; k < candidates_.size();) {
      const bool edge = candidates_[k].kind == FeatureKind::edge;
      const FeatureRow& row = rows_.of(candidates_[k].kind);
      std::size_t end = k;
      double nearest = 1e300;
      for (; end < candidates_.size() &&
             (end == k || (!edge && candidates_[end].same_contact(candidates_[k])));
           ++end)
        nearest = std::min(nearest, row.distance(slots[end]));
      // Crossed edges count as long as they are less than two radii apart; a corner of the surface
      // may be anywhere in the piece.
      double gap = nearest - (edge ? 2 : 1) * radius;
      if (!edge && solid(*s_.stone.core) &&
          below_faces(s_.stone, s_.node(s_.mesh.corner(candidates_[k].part).node)).width <= 0)
        gap = -radius;
      if (keeps(gap)) {
        least_ = 0;
        for (std::size_t n = k; n < end; ++n)
          if (edge || row.distance(slots[n]) <= nearest + 2 * slack_)
            near_.features.push_back(candidates_[n]);
      } else {
        left_out(gap);
      }
      k = end;
    }
  }

  const StoneView& s_;
  const std::vector<int>& triangles_;
  NearFeatures& near_;
  double slack_;
  double least_ = 1e300;
  Rows rows_;
  std::vector<SurfaceFeature> candidates_;
  std::vector<Closest> all_, best_;
};

}  // namespace

void find_features(const StoneView& view, const std::vector<int>& triangles, double path,
                   double pace, NearFeatures& near) {
  const double radius = view.stone.radius;
  const double slack = std::clamp(margin_steps * pace, least_margin * radius, most_margin * radius);
  Finder(view, triangles, slack, near).run(path);
}

// One contact for each run of features of the same contact: the closest of them. The order is that
// of the features, which is the same on every rank and for every margin. A corner is left out if it
// is so deep that its closest triangle may not be among the candidates.
int touch_surface(const StoneView& s, const std::vector<SurfaceFeature>& features,
                  std::vector<MeshContact>& found) {
  thread_local Rows rows;
  rows.clear();
  for (const SurfaceFeature& f : features) {
    if (f.kind == FeatureKind::edge) rows.add_edges(s, f.own, f.part);
    if (f.kind == FeatureKind::sharp_corner) rows.add_corner(s, f.own, f.part);
  }
  rows.compute();
  const double radius = s.stone.radius, equal = 1e-12 * radius * radius;
  const double deep = std::max(radius, largest_corner_depth * s.ball.radius);
  int lost = -1;
  std::array<std::size_t, 3> slot{};
  for (std::size_t k = 0; k < features.size();) {
    const SurfaceFeature& first = features[k];
    MeshContact contact;
    if (first.kind == FeatureKind::corner) {
      const Vec3 p = s.stone.corner(first.own);
      Closest best;
      for (; k < features.size() && features[k].same_contact(first); ++k) {
        const Closest c = s.mesh.closest(p, features[k].part, s.surface, s.fraction, s.origin);
        if (c.replaces(best, equal)) best = c;
      }
      const bool sided = s.mesh.determine_side(best, p, s.surface, s.fraction, s.origin);
      contact = best.contact;
      if (best.squared > deep * deep) {
        if (sided && contact.distance < 0) lost = contact.patch;
        continue;
      }
    } else {
      const FeatureRow& row = rows.of(first.kind);
      std::size_t& next = slot[static_cast<std::size_t>(first.kind)];
      std::size_t best = k, best_slot = next;
      for (; k < features.size() && features[k].same_contact(first); ++k, ++next)
        if (row.distance(next) < row.distance(best_slot)) best = k, best_slot = next;
      const bool edge = first.kind == FeatureKind::edge;
      if (edge && row.distance(best_slot) > 2 * radius) continue;
      contact = edge ? edge_contact(s, features[best], row, best_slot)
                     : corner_contact(s, features[best], row, best_slot);
    }
    if (contact.distance < radius) found.push_back(contact);
  }
  return lost;
}

}  // namespace trackbed::dem
