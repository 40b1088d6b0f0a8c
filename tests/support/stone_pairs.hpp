// Stones with corners for tests: shapes with their true mass properties, and collisions of two.
#pragma once

#include <limits>
#include <vector>

#include "dem/shape/separation.hpp"
#include "support/scene.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::test {

inline constexpr double rounding = 0.05;  // m at unit scale

inline dem::Template solid_of(const std::vector<geom::Piece>& pieces) {
  const bool one = pieces.size() == 1;
  return geom::template_of(pieces,
                           one ? geom::piece_solid(pieces[0]) : geom::union_solid(pieces, 48), 1);
}

inline geom::Convex cuboid_core(const Vec3& half) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.emplace_back(k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(),
                         k & 4 ? half.z() : -half.z());
  return geom::convex_hull(corners);
}

// Outer half extents, rounding included.
inline dem::Template cuboid(const Vec3& half, double radius = rounding) {
  return solid_of({{cuboid_core(half - Vec3::Constant(radius)), radius}});
}

inline dem::Template stone(std::uint64_t seed, int vertices = 16, double radius = rounding) {
  return solid_of({geom::rounded(geom::stone({.vertices = vertices}, seed), radius)});
}

// Two intersecting stones, an angle of two plates, or a cross of two bars.
inline dem::Template compound(std::uint64_t seed) {
  const auto plate = [](const Vec3& half, const Vec3& at) {
    return geom::Piece{geom::moved(cuboid_core(half), Quat::Identity(), at), rounding};
  };
  if (seed % 3 == 0)
    return solid_of(
        {plate({0.4, 0.3, 0.06}, {0, 0, -0.25}), plate({0.06, 0.3, 0.3}, {-0.34, 0, 0})});
  if (seed % 3 == 1)
    return solid_of({plate({0.45, 0.08, 0.1}, {0, 0, 0}), plate({0.07, 0.4, 0.09}, {0.1, 0, 0})});
  std::vector<geom::Piece> two;
  for (std::uint64_t k = 0; k < 2; ++k) {
    geom::Piece piece = geom::rounded(geom::stone({.vertices = 12}, 2 * seed + k), rounding);
    piece.core = geom::moved(piece.core, Quat(1, 0.3 * static_cast<double>(k), 0.2, 0).normalized(),
                             Vec3(k ? 0.3 : -0.3, 0.1 * static_cast<double>(k), 0));
    two.push_back(piece);
  }
  return solid_of(two);
}

// Least distance of two stones' surfaces, m (negative: overlap, only roughly).
inline double gap_of(const dem::Template& a, const dem::NewParticle& pa, const dem::Template& b,
                     const dem::NewParticle& pb) {
  struct Ready {
    dem::Core core;
    std::vector<dem::Vec4> corners;
  };
  const auto ready = [](const dem::Template& shape, const dem::NewParticle& p) {
    std::vector<Ready> all;
    for (const geom::Piece& piece : shape.pieces) {
      Ready r{dem::core_of(piece), {}};
      for (const dem::Vec4& c : r.core.corners) {
        r.corners.emplace_back();
        r.corners.back().set(p.attitude * Vec3(p.scale * c.vec3()));
      }
      all.push_back(r);
    }
    return all;
  };
  double least = std::numeric_limits<double>::infinity();
  for (const Ready& i : ready(a, pa))
    for (const Ready& j : ready(b, pb)) {
      const double ri = i.core.radius * pa.scale, rj = j.core.radius * pb.scale;
      const Vec3 d = pb.position - pa.position;
      const dem::Slab slab = dem::widest_slab({&i.core, i.corners, Vec3::Zero(), ri},
                                              {&j.core, j.corners, d, rj}, d.normalized(), 1e-12);
      least = std::min(least, slab.width - ri - rj);
    }
  return least;
}

// Moves the second along `direction` (unit) until a gap of `gap` m remains between them.
inline void bring_near(const dem::Template& a, const dem::NewParticle& pa, const dem::Template& b,
                       dem::NewParticle& pb, double gap, const Vec3& direction) {
  for (int k = 0; k < 2000; ++k) {
    const double ahead = gap_of(a, pa, b, pb) - gap;
    pb.position += ahead * direction;  // never beyond contact: the gap closes by no more
    if (ahead < 1e-3 * gap) return;
  }
}

// Towards the centre of the other.
inline void bring_near(const dem::Template& a, const dem::NewParticle& pa, const dem::Template& b,
                       dem::NewParticle& pb, double gap) {
  bring_near(a, pa, b, pb, gap, (pa.position - pb.position).normalized());
}

}  // namespace trackbed::test
