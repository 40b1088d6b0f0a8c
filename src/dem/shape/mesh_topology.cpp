// Patches, borders, sharp edges and corners of a surface. Made once for each surface that is set,
// identically on every rank; n log n in the triangles. Parts that are not manifold (an edge of
// three triangles, or of one) are open edges: nothing is assumed about them.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "dem/shape/mesh.hpp"

namespace trackbed::dem {

namespace {

// Union by lowest number with halved paths (Tarjan 1975, doi:10.1145/321879.321884): the result
// does not depend on the order of joining, so patches get the same numbers on every rank.
class Sets {  // disjoint sets, each named by its lowest member
 public:
  explicit Sets(std::size_t size) : root_(size) {
    std::iota(root_.begin(), root_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t k) {
    while (root_[k] != k) k = root_[k] = root_[root_[k]];
    return k;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a), b = find(b);
    root_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> root_;
};

enum class Bend { smooth, convex, concave, open };

struct Side {  // an edge of the mesh
  std::array<std::int32_t, 2> nodes;
  std::vector<std::size_t> triangles;  // ascending
  Bend bend = Bend::open;
};

}  // namespace

// The steps of `Mesh::Mesh`, with temporary data.
class MeshBuilder {
 public:
  MeshBuilder(Mesh& mesh, const Surface& surface)
      : mesh_(mesh), surface_(surface), patches_(mesh.triangles_.size()) {}

  void run() {
    find_sides();
    join_patches();
    mark_borders();
    find_sharp_edges();
    find_chains_and_corners();
    mesh_.edges_at_ = sorted(mesh_.edges_, [](const SharpEdge& e) { return e.triangles[0]; });
    mesh_.corners_at_ = sorted(mesh_.corners_, [](const SharpCorner& c) { return c.triangle; });
  }

 private:
  Vec3 at(std::int32_t node) const { return surface_.position[static_cast<std::size_t>(node)]; }
  Vec3 normal(std::size_t t) const {
    const auto& n = mesh_.triangles_[t];
    return (at(n[1]) - at(n[0])).cross(at(n[2]) - at(n[0])).normalized();
  }

  // An ordered map: sides are in the order of their nodes, not of memory.
  void find_sides() {
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::size_t>> sharing;
    for (std::size_t t = 0; t < mesh_.triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        sharing[std::minmax(mesh_.triangles_[t][k], mesh_.triangles_[t][(k + 1) % 3])].push_back(t);
    for (auto& [nodes, triangles] : sharing) {
      sides_.push_back({{nodes.first, nodes.second}, std::move(triangles), Bend::open});
      sides_.back().bend = bend_of(sides_.back());
    }
  }

  // Convex if the second triangle's own node is below the plane of the first.
  Bend bend_of(const Side& side) const {
    if (side.triangles.size() != 2) return Bend::open;
    const Vec3 n = normal(side.triangles[0]);
    // A bend below `smooth_angle` approximates a curved or a slightly uneven face.
    if (n.dot(normal(side.triangles[1])) > std::cos(smooth_angle)) return Bend::smooth;
    for (const std::int32_t node : mesh_.triangles_[side.triangles[1]])
      if (node != side.nodes[0] && node != side.nodes[1])
        return n.dot(at(node) - at(side.nodes[0])) < 0 ? Bend::convex : Bend::concave;
    return Bend::open;
  }

  // Over smooth edges, then over convex ones unless this would join the two sides of a concave one.
  void join_patches() {
    // Patches that may not be joined; updated with the joins.
    std::map<std::size_t, std::set<std::size_t>> apart;
    const auto ends = [&](const Side& s) {
      return std::pair(patches_.find(s.triangles[0]), patches_.find(s.triangles[1]));
    };
    for (const Side& s : sides_)
      if (s.bend == Bend::smooth) patches_.join(s.triangles[0], s.triangles[1]);
    for (const Side& s : sides_)
      if (s.bend == Bend::concave)
        if (const auto [a, b] = ends(s); a != b) apart[a].insert(b), apart[b].insert(a);
    for (const Side& s : sides_) {
      if (s.bend != Bend::convex) continue;
      const auto [a, b] = ends(s);
      if (a == b || apart[a].contains(b)) continue;
      patches_.join(a, b);
      const std::size_t kept = std::min(a, b), gone = std::max(a, b);
      for (const std::size_t other : apart[gone])
        apart[other].erase(gone), apart[other].insert(kept), apart[kept].insert(other);
      apart.erase(gone);
    }
    // Numbered by the lowest triangle, which is the root and comes first.
    mesh_.patch_.resize(mesh_.triangles_.size());
    for (std::size_t t = 0; t < mesh_.triangles_.size(); ++t)
      mesh_.patch_[t] = patches_.find(t) == t ? mesh_.patches_++ : mesh_.patch_[patches_.find(t)];
  }

  // Within the patch a side is no border, whatever its bend.
  Mesh::Border border_of(const Side& s) {
    const bool within =
        s.triangles.size() == 2 && patches_.find(s.triangles[0]) == patches_.find(s.triangles[1]);
    if (within) return Mesh::Border::inner;
    return s.bend == Bend::concave ? Mesh::Border::crease : Mesh::Border::open;
  }

  void mark_borders() {
    std::map<std::pair<int, std::int32_t>, Mesh::Border> nodes;  // the most open side applies
    mesh_.border_.assign(mesh_.triangles_.size(), {});
    // `part` has a bit for each of the triangle's nodes on the side, as Closest::part.
    for (const Side& s : sides_)
      for (const std::size_t t : s.triangles) {
        unsigned part = 0;
        for (unsigned k = 0; k < 3; ++k)
          if (const auto n = mesh_.triangles_[t][k]; n == s.nodes[0] || n == s.nodes[1])
            part |= 1u << k;
        const Mesh::Border border = border_of(s);
        mesh_.border_[t][part] = border;
        for (const std::int32_t n : s.nodes) {
          Mesh::Border& node = nodes[{mesh_.patch_[t], n}];
          node = std::max(node, border);
        }
      }
    // A node belongs to several sides and, in one patch, to several triangles: all of these get one
    // value.
    for (std::size_t t = 0; t < mesh_.triangles_.size(); ++t)
      for (unsigned k = 0; k < 3; ++k)
        mesh_.border_[t][1u << k] = nodes[{mesh_.patch_[t], mesh_.triangles_[t][k]}];
  }

  // Concave edges do not count: an edge of a convex stone cannot be in contact with them.
  void find_sharp_edges() {
    for (const Side& s : sides_) {
      if (s.bend != Bend::convex && s.bend != Bend::open) continue;
      const bool two = s.triangles.size() == 2;
      mesh_.edges_.push_back(
          {s.nodes,
           {static_cast<int>(s.triangles[0]), two ? static_cast<int>(s.triangles[1]) : -1},
           0});
    }
  }

  // Where exactly two sharp edges are joined almost straight, they continue as one.
  void find_chains_and_corners() {
    std::map<std::int32_t, std::vector<std::size_t>> edges_at;
    for (std::size_t e = 0; e < mesh_.edges_.size(); ++e)
      for (const std::int32_t n : mesh_.edges_[e].nodes) edges_at[n].push_back(e);
    Sets chains(mesh_.edges_.size());
    // Three edges at a node, or two that bend, make a corner, which is a separate feature.
    for (const auto& [node, edges] : edges_at) {
      const auto away = [&, here = node](std::size_t e) {
        const auto& n = mesh_.edges_[e].nodes;
        return (at(n[0] == here ? n[1] : n[0]) - at(here)).normalized();
      };
      if (edges.size() == 2 && -away(edges[0]).dot(away(edges[1])) > std::cos(smooth_angle))
        chains.join(edges[0], edges[1]);
      else
        mesh_.corners_.push_back({node, mesh_.edges_[edges[0]].triangles[0]});
    }
    for (std::size_t e = 0; e < mesh_.edges_.size(); ++e)
      mesh_.edges_[e].chain = static_cast<int>(chains.find(e));
  }

  // Counting sort into one list for each triangle.
  template <class Item, class Triangle>
  Mesh::Numbers sorted(const std::vector<Item>& items, Triangle&& triangle) const {
    Mesh::Numbers lists;
    lists.begin.assign(mesh_.triangles_.size() + 1, 0);
    for (const Item& item : items) ++lists.begin[static_cast<std::size_t>(triangle(item)) + 1];
    std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
    lists.numbers.resize(items.size());
    std::vector<int> next = lists.begin;
    for (std::size_t k = 0; k < items.size(); ++k)
      lists
          .numbers[static_cast<std::size_t>(next[static_cast<std::size_t>(triangle(items[k]))]++)] =
          static_cast<int>(k);
    return lists;
  }

  Mesh& mesh_;
  const Surface& surface_;
  Sets patches_;
  std::vector<Side> sides_;
};

Mesh::Mesh(const Surface& surface) : triangles_(surface.triangles) {
  MeshBuilder(*this, surface).run();
}

}  // namespace trackbed::dem
