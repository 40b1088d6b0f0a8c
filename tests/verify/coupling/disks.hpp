// A plane bed of disks on a ground of elements, between walls without friction (so that only the
// ground carries the weight of the stones), under one sleeper.
#pragma once

#include "trackbed/bed/bed.hpp"
#include "unit/fem/ground_scene.hpp"
#include "verify/coupling/coupled.hpp"

namespace trackbed::test {

struct DiskBed {
  double length = 0.8;  // m, between the walls
  int columns = 12, rows = 4;
  double damping = 0.3;  // local, of stones
  double dt = 1e-4;      // s, window of one sub-step
};

inline dem::Physics disk_physics(double damping) {
  dem::Physics physics;
  physics.materials = {{.name = "stone"}, {.name = "wall"}};
  physics.materials[0].local_damping = damping;
  for (const char* other : {"stone", "wall"}) {
    dem::ContactLaw law;
    law.first = "stone", law.second = other;
    law.k_n = law.k_s = 1e7;
    law.friction = other[0] == 's' ? 0.5 : 0;
    law.zeta_n = law.zeta_s = 0.2;
    physics.laws.push_back(law);
  }
  return physics;
}

inline dem::Domain disk_domain(const DiskBed& bed) {
  dem::Domain domain;
  domain.dimension = Dimension::plane;
  domain.low = {0, -0.5, -0.5};
  domain.high = {bed.length, 0.5, 2};
  return domain;
}

// Soft and damped, so that the ground deflects and reaches static equilibrium.
inline fem::GroundParameters disk_ground(const DiskBed& bed) {
  fem::GroundParameters p = fem::box({bed.length, 1, 0.4}, {8, 1, 4}, {20e6, 0.3, 1800});
  p.base = fem::Base::fixed;
  p.rayleigh_mass = 100;
  return p;
}

// Loose columns of disks of 24 to 30 mm, and the ground in equilibrium under its own weight.
inline void fill(Coupled& scene, const DiskBed& bed) {
  scene.ground.emplace(scene.comm, disk_ground(bed), Dimension::plane, 1.0);
  scene.ground->settle(std::vector<Vec3>(scene.ground->top().nodes(), Vec3::Zero()));
  scene.walls = bed::walls(disk_domain(bed), 1, 1, false);
  scene.particles.add_template(disk());
  std::vector<dem::NewParticle> all;
  const double spacing = bed.length / bed.columns;
  for (int i = 0; i < bed.columns; ++i)
    for (int k = 0; k < bed.rows; ++k) {
      dem::NewParticle p;
      p.id = static_cast<Id>(all.size());
      p.scale = 0.024 + 0.006 * uniform(1, all.size());
      p.position = {spacing * (i + 0.5), 0, 0.033 + spacing * k};
      p.velocity = {0.2 * (uniform(2, all.size()) - 0.5), 0, 0};
      all.push_back(p);
    }
  scene.particles.add(mine(scene.comm, all));
  scene.register_surfaces();
}

inline double top_of_stones(const Coupled& scene) {
  double top = 0;
  for (std::size_t i = 0; i < scene.particles.size(); ++i)
    top = std::max(top, scene.particles[i].position.z() + scene.particles[i].scale);
  return scene.comm.max(top);
}

inline void place_sleeper(Coupled& scene, const DiskBed& bed,
                          const std::vector<std::string>& free = {"x", "z", "ry"}) {
  track::SleeperParameters one;
  one.count = 1, one.first = bed.length / 2, one.free = free;
  scene.sleepers.emplace(one, Dimension::plane, 1.0, 0);
  scene.sleepers->place(top_of_stones(scene));
  scene.register_surfaces();
}

}  // namespace trackbed::test
