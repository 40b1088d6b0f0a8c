// State of RigidSleepers: the bodies, their shape and the free degrees of freedom.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "track/sleepers/prism.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::track {

// State of one sleeper; sleepers_file.cpp lists it for the checkpoint. m, m/s, m/s^2 of the centre
// relative to the placed position; spin in rad/s, turning (angular acceleration) in rad/s^2 and
// reaction in N in space axes. velocity and spin are those at mid-window (leapfrog).
struct Body {
  Vec3 displacement = Vec3::Zero(), velocity = Vec3::Zero(), acceleration = Vec3::Zero();
  Quat attitude = Quat::Identity();
  Vec3 spin = Vec3::Zero(), turning = Vec3::Zero(), reaction = Vec3::Zero();
};

// Bitwise identical on every rank.
struct RigidSleepers::Impl {
  struct Kick {
    double time, gravity;  // s, from mid-window to mid-window; m/s^2
  };
  Impl(const SleeperParameters& given, Dimension dimension, double thickness);
  Vec3 placed_centre(std::size_t i) const;
  Vec3 centre(std::size_t i) const { return placed_centre(i) + bodies[i].displacement; }
  Mat3 inertia(const Body& body) const;
  Vec3 torque(std::size_t i, std::span<const Vec3> node_force) const;
  Vec3 angular_acceleration(const Body& body, const Vec3& torque) const;
  // m, position of a node from the pose.
  Vec3 node(std::size_t i, std::size_t n) const {
    return centre(i) + bodies[i].attitude * shape.position[n];
  }
  Vec3 seat_torque(const Body& body, std::span<const double> seat_force) const;
  void kick(std::size_t i, std::span<const double> seat_force, std::span<const Vec3> node_force,
            const Kick& by);
  void drift(std::size_t i, double dt);
  void show_at_rest();

  SleeperParameters parameters;
  Prism prism;
  Surface shape;                    // about the centre of mass
  double mass;                      // kg
  Vec3 free_shift = Vec3::Zero();   // 1 for a free translation, else 0
  std::array<bool, 3> free_turn{};  // about x, y, z
  std::vector<Body> bodies;
  std::vector<Surface> surfaces;
  double bottom = 0, last_step = 0;  // m; s, length of the last window
  bool placed = false;
};

}  // namespace trackbed::track
