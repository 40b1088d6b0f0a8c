// Distance and depth of convex cores compared with brute force.
#include <gtest/gtest.h>

#include <algorithm>

#include "dem/shape/features.hpp"
#include "support/stone_pairs.hpp"

namespace trackbed::separation_test {
namespace {

// A core of a random stone, box, plate, bar or point of about 1 m, rotated and moved.
struct Body {
  dem::Core core;
  std::vector<dem::Vec4> corners;
  dem::Placed placed() const { return {&core, corners, Vec3::Zero(), core.radius}; }
  Vec3 corner(std::size_t k) const { return corners[k].vec3(); }
};

Vec3 draw(std::uint64_t key, std::uint64_t k) {
  return Vec3(uniform(k, key), uniform(k + 1, key), uniform(k + 2, key)) - Vec3::Constant(0.5);
}

Body body(std::uint64_t key, const Vec3& centre) {
  geom::Convex core;
  switch (key % 5) {
    case 0:
      core = test::cuboid_core({0.5, 0.3, 0.2});
      break;
    case 1:
      core = geom::convex_hull({{-0.5, 0, 0}, {0.5, 0, 0}});
      break;
    case 2:
      core = geom::convex_hull({{-0.5, 0, 0}, {0.3, 0, 0.4}, {0.4, 0, -0.3}});
      break;
    case 3:
      core = geom::ball(Vec3::Zero(), 1).core;
      break;
    default:
      core = geom::stone({.vertices = 14}, key);
  }
  const Quat turn = Quat(0.1 + uniform(1, key), uniform(2, key), uniform(3, key), uniform(4, key));
  Body b{dem::core_of({geom::moved(core, turn.normalized(), centre), 0.05}), {}};
  b.corners = b.core.corners;
  return b;
}

double between_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // The distance to the second is convex along the first: search by thirds.
  const auto from = [&](double s) {
    const Vec3 p = a + s * (b - a);
    const double t = std::clamp((p - c).dot(d - c) / (d - c).squaredNorm(), 0.0, 1.0);
    return (p - c - t * (d - c)).norm();
  };
  double low = 0, high = 1;
  for (int k = 0; k < 120; ++k) {
    const double one = low + (high - low) / 3, other = high - (high - low) / 3;
    (from(one) < from(other) ? high : low) = from(one) < from(other) ? other : one;
  }
  return from(0.5 * (low + high));
}

// Least distance over all features; valid for separate cores.
double brute_distance(const Body& a, const Body& b) {
  double least = 1e300;
  for (std::size_t i = 0; i < a.corners.size(); ++i)
    for (std::size_t j = 0; j < b.corners.size(); ++j)
      least = std::min(least, (a.corner(i) - b.corner(j)).norm());
  const auto to_triangles = [&](const Body& own, const Body& other) {
    for (const dem::Vec4& c : own.corners)
      for (const auto& t : other.core.triangles) {
        const Vec3 p[3] = {other.corner(t[0]), other.corner(t[1]), other.corner(t[2])};
        const Vec3 w = dem::closest_weights(c.vec3(), p[0], p[1], p[2]);
        least = std::min(least, (c.vec3() - w[0] * p[0] - w[1] * p[1] - w[2] * p[2]).norm());
      }
  };
  to_triangles(a, b), to_triangles(b, a);
  for (const auto& e : a.core.edges)
    for (const auto& f : b.core.edges)
      least = std::min(
          least, between_segments(a.corner(e[0]), a.corner(e[1]), b.corner(f[0]), b.corner(f[1])));
  return least;
}

// The widest slab over directions: 4000 spread over the sphere, the best few refined at random.
double brute_width(const Body& a, const Body& b) {
  constexpr int count = 4000, starts = 12;
  std::vector<std::pair<double, Vec3>> seen;
  const auto width_of = [&](const Vec3& n) { return dem::slab_width(a.placed(), b.placed(), n); };
  for (int k = 0; k < count; ++k) {
    const double z = 1 - (2 * k + 1.0) / count, turn = 2.399963229728653 * k;  // golden angle
    const double across = std::sqrt(1 - z * z);
    const Vec3 n(across * std::cos(turn), across * std::sin(turn), z);
    seen.emplace_back(width_of(n), n);
  }
  std::partial_sort(seen.begin(), seen.begin() + starts, seen.end(),
                    [](const auto& one, const auto& other) { return one.first > other.first; });
  std::uint64_t key = 0;
  for (int s = 0; s < starts; ++s) {
    auto& [best, axis] = seen[static_cast<std::size_t>(s)];
    for (double size = 0.1; size > 1e-7; size *= 0.93)
      for (int k = 0; k < 24; ++k) {
        const Vec3 n = (axis + size * draw(++key, 1)).normalized();
        const double width = width_of(n);
        if (width > best) best = width, axis = n;
      }
  }
  double best = seen[0].first;
  for (int s = 1; s < starts; ++s) best = std::max(best, seen[static_cast<std::size_t>(s)].first);
  return best;
}

TEST(Separation, WidestSlabIsTheDistance) {
  constexpr double wanted = 1e-9;  // m, of bodies of 1 m
  int apart = 0;
  for (std::uint64_t key = 0; key < 600; ++key) {
    const Body a = body(2 * key, Vec3::Zero());
    const Body b = body(key % 7 + 5 * key, 1.5 * draw(key, 11) + Vec3(0.4, 0, 0));
    const dem::Slab slab =
        dem::widest_slab(a.placed(), b.placed(), draw(key, 30).normalized(), wanted);
    EXPECT_NEAR(slab.width, dem::slab_width(a.placed(), b.placed(), slab.normal), 1e-15);
    if (!(slab.width > 0)) continue;
    ++apart;
    EXPECT_NEAR(slab.width, brute_distance(a, b), 2 * wanted) << key;
  }
  EXPECT_GT(apart, 200);
}

TEST(Separation, CoresThatOverlapHaveNoEmptySlab) {
  // GJK finds a separation exactly where the separating axes do, if one of the cores has an inside.
  int deep = 0;
  for (std::uint64_t key = 0; key < 600; ++key) {
    const Body a = body(key % 2 ? 5 * key : 5 * key + 4, Vec3::Zero());
    const Body b = body(3 * key + 1, draw(key, 11));
    const dem::Slab all = dem::separating_axis(a.placed(), b.placed());
    const dem::Slab some = dem::widest_slab(a.placed(), b.placed(), Vec3::UnitX(), 1e-10);
    if (std::abs(all.width) < 1e-8) continue;
    EXPECT_EQ(all.width > 0, some.width > 0) << key;
    deep += all.width < 0;
  }
  EXPECT_GT(deep, 100);
}

TEST(Separation, SeparatingAxisIsTheSmallestSeparation) {
  int deep = 0;
  for (std::uint64_t key = 0; key < 300; ++key) {
    const Body a = body(key % 2 ? 5 * key : 5 * key + 4, Vec3::Zero());
    Body b = body(key % 3 ? 5 * key + 9 : 5 * key, 0.7 * draw(key, 11));
    const dem::Slab slab = dem::separating_axis(a.placed(), b.placed());
    if (slab.width > 0) continue;
    ++deep;
    const double brute = brute_width(a, b);
    EXPECT_GE(slab.width, brute - 1e-12) << key;
    EXPECT_NEAR(slab.width, brute, 1e-5) << key;  // accuracy of the refinement of directions
    for (dem::Vec4& c : b.corners) c.set(c.vec3() + (1e-9 - slab.width) * slab.normal);
    EXPECT_GT(dem::slab_width(a.placed(), b.placed(), slab.normal), 0) << key;
  }
  EXPECT_GT(deep, 100);
}

}  // namespace
}  // namespace trackbed::separation_test
