// Small grounds of tetrahedra, and their mesh files.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// A box from z = -size.z to 0, each cell divided into six tetrahedra along its diagonal. `move`
// shifts nodes from their places: corners only, with straight edges, or all nodes.
struct TetBox {
  enum class Edges { straight, curved };
  using Move = std::function<Vec3(const Vec3&)>;
  TetBox(const Vec3& size, std::array<int, 3> cells, const Move& move = {},
         Edges edges = Edges::straight);

  struct Face {
    std::array<int, 6> nodes;
    int side;  // of `sides`
  };
  static constexpr std::array<const char*, 6> sides = {"x0", "x1", "y0", "y1", "bottom", "top"};
  std::vector<Vec3> node;
  std::vector<std::array<int, 10>> tetrahedron;  // Gmsh's order
  std::vector<int> volume;                       // of each tetrahedron: 0 unless a test sets it
  std::vector<std::string> volumes = {"soil"};
  std::vector<Face> face;

  std::string text_4() const;  // format 4.1
  std::string text_2() const;  // format 2.2
};

inline TetBox::TetBox(const Vec3& size, std::array<int, 3> cells, const Move& move, Edges edges) {
  // Corners and middles of edges are the points of a lattice twice as fine.
  const std::array<int, 3> fine = {2 * cells[0], 2 * cells[1], 2 * cells[2]};
  using Place = std::array<int, 3>;
  const auto number = [&](const Place& p) {
    return p[0] + (fine[0] + 1) * (p[1] + (fine[1] + 1) * p[2]);
  };
  const auto home = [&](const Place& p) {
    return Vec3(size.x() * p[0] / fine[0], size.y() * p[1] / fine[1],
                size.z() * (static_cast<double>(p[2]) / fine[2] - 1));
  };
  std::vector<Place> places;
  for (int k = 0; k <= fine[2]; ++k)
    for (int j = 0; j <= fine[1]; ++j)
      for (int i = 0; i <= fine[0]; ++i) {
        places.push_back({i, j, k});
        node.push_back(move ? move(home(places.back())) : home(places.back()));
      }
  constexpr std::array<std::array<int, 3>, 6> orders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  constexpr std::array<std::array<std::size_t, 2>, 6> ends = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}}};
  constexpr std::array<std::array<std::size_t, 6>, 4> triangles = {
      {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 9, 7}, {1, 2, 3, 5, 8, 9}, {0, 3, 2, 7, 8, 6}}};
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        for (std::size_t order = 0; order < 6; ++order) {
          std::array<Place, 4> corner;
          corner.fill({2 * i, 2 * j, 2 * k});
          for (std::size_t step = 0; step < 3; ++step)
            for (std::size_t later = step + 1; later < 4; ++later)
              corner[later][static_cast<std::size_t>(orders[order][step])] += 2;
          if (order > 2) std::swap(corner[1], corner[2]);  // odd permutations are left-handed
          std::array<Place, 10> ten;
          std::copy(corner.begin(), corner.end(), ten.begin());
          for (std::size_t e = 0; e < 6; ++e)
            for (std::size_t a = 0; a < 3; ++a)
              ten[4 + e][a] = (corner[ends[e][0]][a] + corner[ends[e][1]][a]) / 2;
          std::array<int, 10> numbers{};
          for (std::size_t n = 0; n < 10; ++n) numbers[n] = number(ten[n]);
          for (std::size_t e = 0; e < 6 && edges == Edges::straight; ++e)
            node[static_cast<std::size_t>(numbers[4 + e])] =
                0.5 * (node[static_cast<std::size_t>(numbers[ends[e][0]])] +
                       node[static_cast<std::size_t>(numbers[ends[e][1]])]);
          tetrahedron.push_back(numbers);
          volume.push_back(0);
          for (const auto& triangle : triangles)
            for (int side = 0; side < 6; ++side) {
              const auto a = static_cast<std::size_t>(side / 2);
              const int level = side % 2 == 0 ? 0 : fine[a];
              Face outer{{}, side};
              bool on = true;
              for (std::size_t n = 0; n < 6; ++n) {
                on = on && ten[triangle[n]][a] == level;
                outer.nodes[n] = numbers[triangle[n]];
              }
              if (on) face.push_back(outer);
            }
        }
}

namespace detail {
inline std::string listed(const auto& nodes) {
  std::string text;
  for (const int n : nodes) text += fmt::format(" {}", n + 1);
  return text;
}
inline std::string names_of(const TetBox& box) {
  std::string text = fmt::format("$PhysicalNames\n{}\n", 6 + box.volumes.size());
  for (std::size_t s = 0; s < 6; ++s) text += fmt::format("2 {} \"{}\"\n", s + 1, box.sides[s]);
  for (std::size_t v = 0; v < box.volumes.size(); ++v)
    text += fmt::format("3 {} \"{}\"\n", v + 1, box.volumes[v]);
  return text + "$EndPhysicalNames\n";
}
}  // namespace detail

// One entity for each group, with the same number.
inline std::string TetBox::text_4() const {
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + detail::names_of(*this);
  text += fmt::format("$Entities\n0 0 6 {}\n", volumes.size());
  for (std::size_t s = 1; s <= 6; ++s) text += fmt::format("{} 0 0 0 1 1 1 1 {} 0\n", s, s);
  for (std::size_t v = 1; v <= volumes.size(); ++v)
    text += fmt::format("{} 0 0 0 1 1 1 1 {} 2 1 -2\n", v, v);
  text += fmt::format("$EndEntities\n$Nodes\n1 {0} 1 {0}\n3 1 0 {0}\n", node.size());
  for (std::size_t n = 1; n <= node.size(); ++n) text += fmt::format("{}\n", n);
  for (const Vec3& x : node) text += fmt::format("{:.17g} {:.17g} {:.17g}\n", x.x(), x.y(), x.z());
  std::string blocks;
  std::size_t count = 0, number = 0;
  for (int s = 0; s < 6; ++s) {
    std::string rows;
    std::size_t own = 0;
    for (const Face& f : face)
      if (f.side == s) rows += fmt::format("{}{}\n", ++number, detail::listed(f.nodes)), ++own;
    if (own > 0) blocks += fmt::format("2 {} 9 {}\n{}", s + 1, own, rows), ++count;
  }
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    std::string rows;
    std::size_t own = 0;
    for (std::size_t e = 0; e < tetrahedron.size(); ++e)
      if (volume[e] == static_cast<int>(v))
        rows += fmt::format("{}{}\n", ++number, detail::listed(tetrahedron[e])), ++own;
    if (own > 0) blocks += fmt::format("3 {} 11 {}\n{}", v + 1, own, rows), ++count;
  }
  return text + fmt::format("$EndNodes\n$Elements\n{} {} 1 {}\n{}$EndElements\n", count, number,
                            number, blocks);
}

inline std::string TetBox::text_2() const {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + detail::names_of(*this);
  text += fmt::format("$Nodes\n{}\n", node.size());
  for (std::size_t n = 0; n < node.size(); ++n)
    text +=
        fmt::format("{} {:.17g} {:.17g} {:.17g}\n", n + 1, node[n].x(), node[n].y(), node[n].z());
  text += fmt::format("$EndNodes\n$Elements\n{}\n", face.size() + tetrahedron.size());
  std::size_t number = 0;
  for (int s = 0; s < 6; ++s)
    for (const Face& f : face)
      if (f.side == s)
        text += fmt::format("{} 9 2 {} {}{}\n", ++number, s + 1, s + 1, detail::listed(f.nodes));
  for (std::size_t v = 0; v < volumes.size(); ++v)
    for (std::size_t e = 0; e < tetrahedron.size(); ++e)
      if (volume[e] == static_cast<int>(v))
        text += fmt::format("{} 11 2 {} {}{}\n", ++number, v + 1, v + 1,
                            detail::listed(tetrahedron[e]));
  return text + "$EndElements\n";
}

// All borders rollers except a fixed bottom; written once per number of ranks and name.
inline GroundParameters of_mesh(const TetBox& box, const std::string& name, const Elastic& solid) {
  const par::Comm world = par::Comm::world();
  GroundParameters p;
  p.mesh = fmt::format("{}_on_{}.msh", name, world.size());
  if (world.root()) std::ofstream(p.mesh) << box.text_4();
  world.max(0.0);  // no rank reads before the file is written
  for (const std::string& volume : box.volumes) p.solids.push_back({volume, solid});
  for (std::size_t s = 0; s < 5; ++s)
    p.borders.push_back({box.sides[s], s == 4 ? BorderKind::fixed : BorderKind::roller});
  p.integrator = Integrator::newmark;
  return p;
}

// Nodal forces, N, of a pressure (Pa, at the middle of each triangle) on a surface.
inline std::vector<Vec3> pressure_forces(const Surface& top,
                                         const std::function<double(const Vec3&)>& pressure) {
  std::vector<Vec3> force(top.nodes(), Vec3::Zero());
  for (const auto& t : top.triangles) {
    const auto at = [&](std::size_t k) { return top.position[static_cast<std::size_t>(t[k])]; };
    const Vec3 area = 0.5 * (at(1) - at(0)).cross(at(2) - at(0));
    const double p = pressure((at(0) + at(1) + at(2)) / 3);
    for (const std::int32_t n : t) force[static_cast<std::size_t>(n)] -= p * area / 3;
  }
  return force;
}

// Moves nodes inside a box, and along its faces, by a `fraction` of a cell.
inline TetBox::Move shaken(const Vec3& size, std::array<int, 3> cells, double fraction) {
  return [=](const Vec3& home) {
    const double z = home.z() + size.z();
    Vec3 at = home;
    for (int a = 0; a < 3; ++a) {
      const double x = a == 2 ? z : home[a];
      const bool border = x < 1e-9 || x > size[a] - 1e-9;
      const double cell = size[a] / cells[static_cast<std::size_t>(a)];
      if (!border)
        at[a] += fraction * cell * std::sin(7.1 * home.x() + 5.3 * home.y() + 3.7 * z + 1.9 * a);
    }
    return at;
  };
}

}  // namespace trackbed::fem
