// Small grounds for tests.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

inline std::string dimension_name(const ::testing::TestParamInfo<Dimension>& info) {
  return info.param == Dimension::plane ? "plane" : "space";
}

inline GroundParameters box(const Vec3& size, std::array<std::int64_t, 3> elements,
                            const Elastic& solid) {
  GroundParameters p;
  p.x = {0, size.x()};
  p.y = {0, size.y()};
  p.elements_x = elements[0], p.elements_y = elements[1], p.elements_z = elements[2];
  p.layers = {{"all", size.z(), solid}};
  return p;
}

// Uniform vertical pressure (Pa) as nodal forces of the top face: a quarter of each element's force
// to each of its corners (two consecutive triangles form an element).
inline std::vector<Vec3> pressure(Ground& ground, double pressure) {
  const Surface& top = ground.top();
  std::vector<Vec3> force(top.nodes(), Vec3::Zero());
  for (std::size_t t = 0; t < top.triangles.size(); t += 2) {
    const auto at = [&](std::size_t triangle, std::size_t corner) {
      return static_cast<std::size_t>(top.triangles[triangle][corner]);
    };
    const std::array<std::size_t, 4> quad = {at(t, 0), at(t, 1), at(t, 2), at(t + 1, 2)};
    const Vec3 a = top.position[quad[0]];
    const double area = (top.position[quad[1]] - a).cross(top.position[quad[3]] - a).norm();
    for (const std::size_t n : quad) force[n].z() -= 0.25 * pressure * area;
  }
  return force;
}

// A column of the reference case: E 50 MPa, nu 0.3, rho 2000, H 10 m, no lateral motion.
inline GroundParameters column(std::int64_t elements) {
  GroundParameters p = box({1, 1, 10}, {1, 1, elements}, {50e6, 0.3, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  return p;
}

}  // namespace trackbed::fem
