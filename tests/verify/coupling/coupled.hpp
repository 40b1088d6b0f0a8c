// Stones, ground and sleepers in the order of the program's time window, without the program.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "support/scene.hpp"
#include "trackbed/couple/coupler.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::test {

class Coupled {
 public:
  Coupled(const par::Comm& world, const dem::Physics& physics, const dem::Domain& domain,
          double weight_per_mass = gravity)
      : comm(world), particles(world, physics, with(weight_per_mass), domain), coupler(world) {}
  Coupled(const Coupled&) = delete;  // surfaces are stored by address
  Coupled& operator=(const Coupled&) = delete;

  // Registers all surfaces with stones and coupler: ground first, then walls, then sleepers.
  void register_surfaces() {
    coupler.clear();
    std::vector<Surface*> surfaces;
    const auto add = [&](Surface& surface, std::vector<int> owner) {
      surfaces.push_back(&surface);
      return coupler.add(surface, std::move(owner));
    };
    if (ground) add(ground->top(), ground->top_owner());
    for (Surface& wall : walls) add(wall, {});
    on_sleeper.clear();
    if (sleepers && sleepers->placed())
      for (Surface& sleeper : sleepers->surfaces()) on_sleeper.push_back(add(sleeper, {}));
    particles.set_surfaces(surfaces);
    rebalance();
  }
  void rebalance() {
    particles.repartition();
    coupler.connect(
        [&](const Vec3& low, const Vec3& high) { return particles.reaches(low, high); });
  }
  // A window: bodies and ground move under the last window's mean forces, then the sub-steps.
  void window(double dt, int substeps, std::span<const double> seat_force = {}) {
    if (!on_sleeper.empty()) {
      std::vector<std::span<const Vec3>> forces;
      for (const std::size_t number : on_sleeper) forces.push_back(coupler.mean_force(number));
      sleepers->advance(dt, seat_force, forces, gravity);
    }
    if (ground) ground->advance(dt, coupler.mean_force(0));
    coupler.publish();
    particles.advance(dt, substeps);
    const dem::SurfaceAction& did = particles.surface_action();
    coupler.collect(substeps, dt, {did.force, did.moment, did.work});
  }
  // Vertical force of the last window on the ground, N, over all ranks.
  double on_ground() const {
    double mine = 0;
    for (const std::int32_t node : ground->own_top())
      mine += coupler.mean_force(0)[static_cast<std::size_t>(node)].z();
    return comm.sum(mine);
  }

  par::Comm comm;
  dem::Particles particles;
  std::optional<fem::Ground> ground;
  std::optional<track::RigidSleepers> sleepers;
  std::vector<Surface> walls;
  couple::Coupler coupler;
  std::vector<std::size_t> on_sleeper;  // numbers in the coupler

 private:
  static dem::Parameters with(double weight_per_mass) {
    dem::Parameters parameters;
    parameters.gravity = weight_per_mass;
    return parameters;
  }
};

}  // namespace trackbed::test
