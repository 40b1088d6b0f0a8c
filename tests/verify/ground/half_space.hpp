// A truncated half space: static solutions under loads on its top, and their stresses.
//
// Truncation error: far from the load its field is that of a point (line) force P, so the missing
// ground changes the field near the load by g(x / L) P / (E L^(d-2)) with L the distance of the
// borders, d = 3 in space, 2 in a plane (plus terms of higher order in the size of the load over
// L). Rollers and a fixed base constrain the field: displacements are too small by order a/L,
// vertical stresses too large by order (z/L)^2.
#pragma once

#include <cmath>
#include <vector>

#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem {

// Solid between rollers on a fixed base for one long implicit window from rest: beta dt^2 K a = F
// and u = beta dt^2 a, the static solution, with relative inertia of order (period / dt)^2 = 1e-8.
inline void load_statically(Ground& ground, const std::vector<Vec3>& force) {
  ground.advance(1e4, force);
}

inline GroundParameters half_space(GroundParameters p) {
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.sides = Sides::roller;
  p.integrator = Integrator::newmark;
  p.tolerance = 1e-9;
  return p;
}

// Stress since settling (xx yy zz xy yz zx, Pa) at points between the elements' centres: the mean
// of the elements whose centres are at most half an element away along each axis, second order in
// their size. The same on all ranks. Cost: points times elements.
using Stress6 = std::array<double, 6>;
inline std::vector<Stress6> stresses_at(const par::Comm& comm, const Ground& ground,
                                        const std::vector<Vec3>& points, const Vec3& element) {
  const io::Grid grid = ground.fields();
  std::vector<double> sums(7 * points.size(), 0.0);
  for (std::size_t c = 0; c < grid.cells.size() / 8; ++c) {
    Vec3 centre = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      centre += grid.points[static_cast<std::size_t>(grid.cells[8 * c + k])] / 8;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Vec3 away = (centre - points[p]).cwiseAbs().cwiseQuotient(element);
      if (away.maxCoeff() > 0.5 + 1e-6) continue;
      for (std::size_t s = 0; s < 6; ++s) sums[7 * p + s] += grid.cell_data[0].values[6 * c + s];
      sums[7 * p + 6] += 1;
    }
  }
  comm.sum(std::span<double>(sums));
  std::vector<Stress6> stresses(points.size());
  for (std::size_t p = 0; p < points.size(); ++p)
    for (std::size_t s = 0; s < 6; ++s) stresses[p][s] = sums[7 * p + s] / sums[7 * p + 6];
  return stresses;
}

}  // namespace trackbed::fem
