// What Bodies keeps.
#pragma once

#include <vector>

#include "bodies_system.hpp"

namespace trackbed::fem {

// The same on every rank to the last bit.
struct Bodies::Room {
  explicit Room(const BodiesParameters& parameters);

  // A body's motion as a whole is a weighted sum over its nodes.
  struct Whole {
    std::vector<double> share;              // of its mass, of each node; sums to 1
    std::array<std::vector<Vec3>, 3> turn;  // 1/m, of the rotation about x, y, z
  };
  static Whole whole_of(const BodyMesh& mesh);
  Vec3 mean(std::size_t body, const BodiesSystem::Vector& values) const;
  Vec3 turn(std::size_t body, const BodiesSystem::Vector& values) const;

  BodiesParameters parameters;
  std::vector<BodyMesh> meshes;
  BodiesSystem system;
  std::vector<Whole> wholes;
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
