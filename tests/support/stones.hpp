// Shapes of pieces with several corners, and surfaces for them.
#pragma once

#include <map>

#include "support/scene.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::test {

// Brick of these half extents (m) with edges of radius r; its inertia is that of the sharp brick.
inline dem::Template brick(const Vec3& half, double r) {
  std::vector<Vec3> corners;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1})
      for (const double z : {-1, 1})
        corners.push_back((half - Vec3::Constant(r)).cwiseProduct(Vec3(x, y, z)));
  dem::Template t;
  t.pieces = {{geom::convex_hull(corners), r}};
  t.volume = 8 * half.prod();
  const Vec3 square = half.cwiseProduct(half);
  t.gyration = (Vec3::Constant(square.sum()) - square) / 3;
  return t;
}

// An irregular stone about 2 `size` long with edges of radius r.
inline dem::Template irregular(double size, double r, std::uint64_t seed) {
  geom::StoneShape shape;
  shape.vertices = 16;
  return geom::template_of({geom::rounded(geom::scaled(geom::stone(shape, seed), 2 * size), r)});
}

// A box with outward normals; its sides are cut into n * n squares of two triangles.
inline Surface block_of(const Vec3& half, int n, const std::string& name = "block") {
  Surface s;
  s.name = name;
  std::map<std::array<int, 3>, std::int32_t> known;
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [found, added] = known.try_emplace(at, static_cast<std::int32_t>(s.nodes()));
    if (added)
      s.position.push_back(half.cwiseProduct(Vec3(at[0], at[1], at[2]) * (2.0 / n) - Vec3::Ones()));
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> k{};
            k[axis] = side, k[(axis + 1) % 3] = i + u, k[(axis + 2) % 3] = j + v;
            return node(k);
          };
          const auto a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
          if (side == 0)
            s.triangles.insert(s.triangles.end(), {{a, c, b}, {a, d, c}});
          else
            s.triangles.insert(s.triangles.end(), {{a, b, c}, {a, c, d}});
        }
  s.motion.assign(s.nodes(), Vec3::Zero());
  s.clear_load();
  return s;
}

}  // namespace trackbed::test
