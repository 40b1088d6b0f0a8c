// Private part of Bodies.
#pragma once

#include <vector>

#include "fem/bodies/bodies_system.hpp"

namespace trackbed::fem {

// Bitwise identical on every rank.
struct Bodies::Impl {
  explicit Impl(const BodiesParameters& parameters);

  // Weights of the nodes of a body; the weighted sum of nodal motion is its rigid-body motion.
  struct RigidWeights {
    std::vector<double> fraction;           // of each node in the mass of the body; sums to 1
    std::array<std::vector<Vec3>, 3> turn;  // 1/m, of the rotation about x, y, z
  };
  static RigidWeights rigid_weights(const BodyMesh& mesh);
  Vec3 mean(std::size_t body, const BodiesSystem::Vector& values) const;
  Vec3 turn(std::size_t body, const BodiesSystem::Vector& values) const;

  BodiesParameters parameters;
  std::vector<BodyMesh> meshes;
  BodiesSystem system;
  std::vector<RigidWeights> rigid;
  Vec3 origin = Vec3::Zero();          // m
  BodiesSystem::Vector force, change;  // N, m: scratch of a step
  BodiesSystem::Vector& cleared_force() {
    force.setZero(system.displacement.size());
    return force;
  }
  std::vector<Surface> surfaces;
  std::vector<std::size_t> touched;                // body of each surface
  std::vector<std::vector<std::int32_t>> node_of;  // of each surface's nodes
};

}  // namespace trackbed::fem
