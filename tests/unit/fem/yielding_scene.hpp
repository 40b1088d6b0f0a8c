// A ground with large yielding regions, for explicit and implicit steps.
#pragma once

#include <cmath>

#include "trackbed/core/hash.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem {

// Two layers, the upper one and a corner of the lower one weak; a non-uniform load in strong
// pulses.
inline GroundParameters yielding_scene() {
  GroundParameters p = box({3, 1, 1}, {13, 4, 5}, {80e6, 0.3, 1900});
  p.layers = {{"weak", 0.55, {60e6, 0.3, 1900}}, {"strong", 0.45, {80e6, 0.3, 1900}}};
  p.layers[0].strength = {Yield::mohr_coulomb, 8e3, 25, 5, 2e3};
  Block block{"corner", true, {0, -0.5, 1, -0.5, 1, -1, 0, -1}, {70e6, 0.25, 2000}};
  block.strength = {Yield::mohr_coulomb, 15e3, 0, 0, 5e3};
  p.blocks = {block};
  p.plane = PlaneState::strain;
  p.sides = Sides::viscous;
  p.rayleigh_stiffness = 1e-5;
  return p;
}

inline std::vector<Vec3> load_of(const Surface& top, int window) {
  std::vector<Vec3> force(top.nodes());
  const double each = 1.2e5 / static_cast<double>(force.size());
  for (std::size_t n = 0; n < force.size(); ++n)
    force[n] = {0.2 * each * std::sin(0.3 * static_cast<double>(n) + window), 0,
                -each * (1 + std::sin(1.7 * static_cast<double>(n))) * (window % 3)};
  return force;
}

// The static load at release: less than a third of the pulses.
inline std::vector<Vec3> settled(const Surface& top) {
  std::vector<Vec3> force = load_of(top, 1);
  for (Vec3& each : force) each *= 0.3;
  return force;
}

inline std::uint64_t bits(const par::Comm& comm, const Ground& ground) {
  std::uint64_t sum = 0;
  for (const std::int32_t n : ground.own_top()) {
    const auto state = ground.top_state(n);
    sum += mix(hash_bytes(state.displacement.data(), 24, static_cast<std::uint64_t>(n)));
    sum += mix(hash_bytes(state.velocity.data(), 24, static_cast<std::uint64_t>(n) + 1000));
    sum += mix(hash_bytes(&state.sigma_z, 8, static_cast<std::uint64_t>(n) + 2000));
  }
  return static_cast<std::uint64_t>(comm.sum(static_cast<std::int64_t>(sum)));
}

}  // namespace trackbed::fem
