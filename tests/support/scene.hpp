// Scenes of particles in a few lines.
#pragma once

#include <vector>

#include "trackbed/core/hash.hpp"
#include "trackbed/dem/particles.hpp"

namespace trackbed::test {

// One material in contact with itself.
inline dem::Physics one_material(const dem::ContactLaw& law, double density = 2500) {
  dem::Physics physics;
  dem::Material stone;
  stone.name = "stone";
  stone.density = density;
  physics.materials = {stone};
  dem::ContactLaw self = law;
  self.first = self.second = "stone";
  physics.laws = {self};
  return physics;
}

inline dem::Template sphere(double radius = 1) {
  dem::Template t;
  t.pieces = {geom::ball(Vec3::Zero(), radius)};
  t.volume = 4.0 / 3.0 * M_PI * radius * radius * radius;
  t.gyration = Vec3::Constant(0.4 * radius * radius);
  return t;
}

// Disk in a plane model: volume is its area.
inline dem::Template disk(double radius = 1) {
  dem::Template t;
  t.pieces = {geom::ball(Vec3::Zero(), radius)};
  t.volume = M_PI * radius * radius;
  t.gyration = Vec3(0.25, 0.5, 0.25) * radius * radius;
  return t;
}

// Three spheres in a row and one aside: an asymmetric clump of unit size.
inline dem::Template clump() {
  dem::Template t;
  t.pieces = {geom::ball({-0.5, -0.08, 0.02}, 0.5), geom::ball({0.5, -0.08, 0.02}, 0.4),
              geom::ball({0, 0.42, -0.05}, 0.35)};
  t.volume = 0.9;
  t.gyration = Vec3(0.08, 0.15, 0.19);
  return t;
}

inline dem::Domain box(const Vec3& low, const Vec3& high) {
  dem::Domain domain;
  domain.low = low, domain.high = high;
  return domain;
}

// A square of side 2 `half` at height z cut into 2 n^2 triangles, normals up.
inline Surface floor_of(int n, double half, double z = 0, const std::string& name = "floor") {
  Surface s;
  s.name = name;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      s.position.push_back({half * (2.0 * i / n - 1), half * (2.0 * j / n - 1), z});
  const auto node = [&](int i, int j) { return static_cast<std::int32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      s.triangles.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
      s.triangles.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
    }
  s.motion.assign(s.nodes(), Vec3::Zero());
  s.clear_load();
  return s;
}

// The particles that this rank makes, by their number (any split is valid).
inline std::vector<dem::NewParticle> mine(const par::Comm& comm,
                                          const std::vector<dem::NewParticle>& all) {
  std::vector<dem::NewParticle> part;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (static_cast<int>(k) % comm.size() == comm.rank()) part.push_back(all[k]);
  return part;
}

// A loose lattice of nx * ny * nz particles of two shapes with random sizes and attitudes.
inline std::vector<dem::NewParticle> lattice(const std::array<int, 3>& n, double spacing,
                                             double radius, int shapes) {
  std::vector<dem::NewParticle> all;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        const auto key = static_cast<std::uint64_t>(all.size());
        dem::NewParticle p;
        p.id = static_cast<Id>(key);
        p.shape = static_cast<int>(key % static_cast<std::uint64_t>(shapes));
        p.scale = radius * (0.8 + 0.2 * uniform(1, key));
        p.position = spacing * Vec3(i + 0.5, j + 0.5, k + 0.5);
        p.velocity = Vec3(uniform(2, key) - 0.5, uniform(3, key) - 0.5, uniform(4, key) - 0.5);
        p.attitude = Quat(1, uniform(5, key), uniform(6, key), uniform(7, key)).normalized();
        p.spin = 20 * Vec3(uniform(8, key) - 0.5, uniform(9, key) - 0.5, uniform(10, key) - 0.5);
        all.push_back(p);
      }
  return all;
}

}  // namespace trackbed::test
