#include "mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "features.hpp"

namespace trackbed::dem {

namespace {

// Which part of a triangle a closest point lies on: its nodes there (1: corner, 2: edge, 3: face).
struct Closest {
  MeshContact contact;
  std::array<std::int32_t, 3> nodes{-1, -1, -1};  // sorted, unused -1 first
  double squared = 0;                             // m^2, distance^2
};

Vec3 normal_of(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a); }

Closest closest_on(const Vec3& p, const std::array<Vec3, 3>& corner,
                   const std::array<std::int32_t, 3>& nodes) {
  Closest result;
  MeshContact& hit = result.contact;
  hit.weight = closest_weights(p, corner[0], corner[1], corner[2]);
  hit.point = hit.weight[0] * corner[0] + hit.weight[1] * corner[1] + hit.weight[2] * corner[2];
  for (std::size_t k = 0, used = 3; k < 3; ++k)
    if (hit.weight[static_cast<int>(k)] > 0) result.nodes[--used] = nodes[k];
  std::sort(result.nodes.begin(), result.nodes.end());
  const Vec3 out = normal_of(corner[0], corner[1], corner[2]).normalized();
  if (result.nodes[0] >= 0) {  // inside the face: the plane's own normal, exact when it is level
    hit.distance = out.dot(p - corner[0]);
    hit.normal = -out;
  } else {
    hit.distance = (hit.point - p).norm();
    hit.normal = hit.distance > 0 ? Vec3((hit.point - p) / hit.distance) : Vec3(-out);
  }
  result.squared = hit.distance * hit.distance;
  return result;
}

bool contains(const std::array<std::int32_t, 3>& triangle,
              const std::array<std::int32_t, 3>& part) {
  return std::all_of(part.begin(), part.end(), [&](std::int32_t node) {
    return node < 0 || std::find(triangle.begin(), triangle.end(), node) != triangle.end();
  });
}

}  // namespace

Mesh::Mesh(const Surface& surface) : triangles_(surface.triangles) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::size_t>> edges;
  std::vector<Vec3> normal(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& n = triangles_[t];
    const auto at = [&](int k) { return surface.position[static_cast<std::size_t>(n[k])]; };
    normal[t] = normal_of(at(0), at(1), at(2)).normalized();
    for (std::size_t k = 0; k < 3; ++k) edges[std::minmax(n[k], n[(k + 1) % 3])].push_back(t);
  }
  // Patches are the connected sets over smooth edges; each is named by its lowest triangle.
  std::vector<std::size_t> root(triangles_.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  for (const auto& [edge, sharing] : edges)
    for (std::size_t k = 1; k < sharing.size(); ++k)
      if (normal[sharing[0]].dot(normal[sharing[k]]) > std::cos(smooth_angle)) {
        const std::size_t a = find(sharing[0]), b = find(sharing[k]);
        root[std::max(a, b)] = std::min(a, b);
      }
  patch_.resize(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    patch_[t] = find(t) == t ? patches_++ : patch_[find(t)];
}

void Mesh::touch(const Ball& ball, const std::vector<int>& candidates, const Surface& surface,
                 double s, std::vector<MeshContact>& found) const {
  const auto& [centre, radius] = ball;
  thread_local std::vector<Closest> near;  // keeps its capacity: no allocation per step
  near.clear();
  for (const int t : candidates) {
    const auto& nodes = triangles_[static_cast<std::size_t>(t)];
    Closest c = closest_on(centre,
                           {node_at(surface, nodes[0], s), node_at(surface, nodes[1], s),
                            node_at(surface, nodes[2], s)},
                           nodes);
    if (std::abs(c.contact.distance) >= radius) continue;
    c.contact.triangle = t;
    c.contact.patch = patch_[static_cast<std::size_t>(t)];
    near.push_back(c);
  }
  const std::size_t first = found.size();
  const double equal =
      1e-12 * radius * radius;  // two distances to the same edge differ by rounding
  for (const Closest& a : near) {
    const bool edge = a.nodes[0] < 0;
    const bool beaten =
        edge && std::any_of(near.begin(), near.end(), [&](const Closest& b) {
          const int other = b.contact.triangle;
          if (other == a.contact.triangle) return false;
          if (!contains(triangles_[static_cast<std::size_t>(other)], a.nodes)) return false;
          const bool preferred = b.nodes[0] >= 0 || other < a.contact.triangle;
          return b.squared < a.squared - equal || (b.squared <= a.squared + equal && preferred);
        });
    if (beaten) continue;
    const auto same =
        std::find_if(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(),
                     [&](const MeshContact& f) { return f.patch == a.contact.patch; });
    if (same == found.end())
      found.push_back(a.contact);
    else if (a.contact.distance < same->distance)
      *same = a.contact;
  }
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(),
            [](const MeshContact& a, const MeshContact& b) { return a.patch < b.patch; });
}

}  // namespace trackbed::dem
