// Partition of a ground of tetrahedra. Nodes and elements are numbered in the order of the file, or
// in that of cutting the embankment.
//
// Every rank builds the whole mesh and keeps its part: no messages, and only the top of the whole
// is kept.
#include <algorithm>

#include "fem/mesh/mesh.hpp"
#include "fem/mesh/solid_mesh.hpp"
#include "fem/mesh/split.hpp"
#include "fem/shape/tetrahedron.hpp"

namespace trackbed::fem {

namespace {

// Elements are neighbours if they share a face, three corners.
std::vector<int> node_owners(const SolidMesh& whole, const Solids& solids, int ranks) {
  if (ranks == 1) return std::vector<int>(whole.position.size(), 0);
  std::vector<std::int32_t> corners, nodes;
  std::vector<std::uint8_t> at_interface(whole.element.size(), 0);
  for (const SolidMesh::Face& face : whole.top)
    at_interface[static_cast<std::size_t>(face.element)] = 1;
  std::vector<double> cost;
  corners.reserve(4 * whole.element.size()), nodes.reserve(10 * whole.element.size());
  for (std::size_t e = 0; e < whole.element.size(); ++e) {
    const auto& of = whole.element[e];
    corners.insert(corners.end(), &of[0], &of[4]);
    nodes.insert(nodes.end(), of.begin(), of.end());
    const auto& strength = solids.strength[static_cast<std::size_t>(whole.solid[e])];
    cost.push_back(tetrahedron_cost.of(strength, at_interface[e] != 0));
  }
  return split_nodes({corners, 4, 3}, cost, nodes, whole.position.size(), ranks);
}

// A six-node face as four triangles of the same orientation.
constexpr std::array<std::array<std::size_t, 3>, 4> quarters = {
    {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};

void make_top(const SolidMesh& whole, Imported& shape) {
  for (const SolidMesh::Face& face : whole.top)
    for (const std::int32_t n : whole.nodes_of(face)) shape.top_node.push_back(n);
  std::sort(shape.top_node.begin(), shape.top_node.end());
  shape.top_node.erase(std::unique(shape.top_node.begin(), shape.top_node.end()),
                       shape.top_node.end());
  for (const Id n : shape.top_node)
    shape.top_place.push_back(whole.position[static_cast<std::size_t>(n)]);
  for (const SolidMesh::Face& face : whole.top) {
    const auto nodes = whole.nodes_of(face);
    for (const auto& quarter : quarters) {
      auto& triangle = shape.top_triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
        triangle[k] = static_cast<std::int32_t>(
            std::lower_bound(shape.top_node.begin(), shape.top_node.end(), nodes[quarter[k]]) -
            shape.top_node.begin());
    }
  }
  shape.top_around.assign(shape.top_node.size(), 0.0);
  // The first three of four triangles contain a corner of the face, at the position of their own
  // number.
  for (std::size_t t = 0; t < shape.top_triangles.size(); ++t) {
    if (t % 4 == 3) continue;
    const auto& triangle = shape.top_triangles[t];
    const auto at = [&](std::size_t k) {
      return shape.top_place[static_cast<std::size_t>(triangle[k])];
    };
    shape.top_around[static_cast<std::size_t>(triangle[t % 4])] +=
        0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
  }
}

}  // namespace

double Imported::area_around(Id corner) const {
  const auto found = std::lower_bound(top_node.begin(), top_node.end(), corner);
  return top_around[static_cast<std::size_t>(found - top_node.begin())];
}

void Mesh::import(const SolidMesh& whole) {
  const std::vector<int> owners = node_owners(whole, solids, comm.size());
  const auto owner = [&](Id n) { return owners[static_cast<std::size_t>(n)]; };
  auto shape = std::make_unique<Imported>();
  shape->elements = static_cast<Id>(whole.element.size());
  shape->nodes = static_cast<Id>(whole.position.size());
  shape->depth = whole.depth();
  for (std::size_t e = 0; e < whole.element.size(); ++e) {
    const auto& nodes = whole.element[e];
    if (std::none_of(nodes.begin(), nodes.end(),
                     [&](std::int32_t n) { return owner(n) == comm.rank(); }))
      continue;
    element.push_back(static_cast<Id>(e));
    solid.push_back(whole.solid[e]);
    node.insert(node.end(), nodes.begin(), nodes.end());
  }
  number(owner);
  for (const Id n : node) shape->place.push_back(whole.position[static_cast<std::size_t>(n)]);
  for (const Id e : element) {
    auto& local = shape->corner.emplace_back();
    for (std::size_t k = 0; k < 10; ++k)
      local[k] = local_node(whole.element[static_cast<std::size_t>(e)][k]);
  }
  const auto keep = [&](const std::vector<SolidMesh::Face>& from, auto& to) {
    for (const SolidMesh::Face& face : from)
      if (const std::int64_t at = local_element(face.element); at >= 0)
        to.push_back({static_cast<std::int32_t>(at), face.side, face.holds, face.axis, face.low});
  };
  keep(whole.borders, shape->borders), keep(whole.top, shape->top);
  make_top(whole, *shape);
  for (const Id n : shape->top_node) top_owner.push_back(owner(n));
  imported = std::move(shape);
  connect(owner);
  first_own = comm.exclusive_scan(static_cast<std::int64_t>(own.size()));
}

}  // namespace trackbed::fem
