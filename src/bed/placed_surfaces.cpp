// Plates and boxes as triangles that move with constant velocities.
//
// Nodes are computed from their initial positions in each window: positions depend on the time
// alone, so they are not part of the state of a run, and rounding cannot deform a plate.
#include <algorithm>
#include <cmath>

#include "plate.hpp"
#include "trackbed/bed/placed.hpp"

namespace trackbed::bed {

namespace {

// Half the extent of surfaces across a plane model: their edges must be out of reach of the stones
// in y = 0.
double half_across(double thickness) { return thickness / 2 + beyond; }

Surface plate_of(const PlateParameters& p, int material, Dimension dimension, double thickness) {
  const Vec3 n = vector_of(p.normal).normalized(), centre = vector_of(p.centre);
  if (dimension == Dimension::plane) {
    const Vec3 first = p.size[0] * Vec3::UnitY().cross(n);
    const Vec3 second = 2 * half_across(thickness) * Vec3::UnitY();
    return plate(p.name, material, centre - (first + second) / 2, first, second);
  }
  Vec3 along = vector_of(p.edge);
  const bool along_x = std::abs(n.x()) > 1 - 1e-12;
  if (along.isZero(0)) along = along_x ? Vec3::UnitY() : Vec3::UnitX();
  const Vec3 first = p.size[0] * (along - along.dot(n) * n).normalized();
  const Vec3 second = p.size[1] * n.cross(first).normalized();
  return plate(p.name, material, centre - (first + second) / 2, first, second);
}

// Corner k has the bits x, y, z: 1 where it is at the high side. Each face counter-clockwise seen
// from outside; those across y come last.
constexpr std::array<std::array<std::int32_t, 4>, 6> faces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}}};

Surface box_of(const BoxParameters& p, int material, Dimension dimension, double thickness) {
  const bool plane = dimension == Dimension::plane;
  Vec3 low = vector_of(p.low), high = vector_of(p.high);
  if (plane) low.y() = -half_across(thickness), high.y() = half_across(thickness);
  const Vec3 centre = (low + high) / 2;
  const Quat turn = turn_of(p.axis, p.angle);
  Surface box;
  box.name = p.name, box.material = material;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner((k & 1) != 0 ? high.x() : low.x(), (k & 2) != 0 ? high.y() : low.y(),
                      (k & 4) != 0 ? high.z() : low.z());
    box.position.push_back(p.angle == 0 ? corner : Vec3(centre + turn * (corner - centre)));
  }
  for (std::size_t f = 0; f < (plane ? 4 : 6); ++f) {
    std::array<std::int32_t, 4> face = faces[f];
    if (p.side == BoxSide::inside) std::reverse(face.begin(), face.end());
    box.triangles.push_back({face[0], face[1], face[2]});
    box.triangles.push_back({face[0], face[2], face[3]});
  }
  box.motion.assign(box.nodes(), Vec3::Zero());
  box.clear_load();
  return box;
}

}  // namespace

PlacedSurfaces::PlacedSurfaces(const std::vector<PlateParameters>& plates,
                               const std::vector<BoxParameters>& boxes, const dem::Physics& physics,
                               Dimension dimension, double thickness) {
  for (const PlateParameters& p : plates)
    add(plate_of(p, physics.material(p.material), dimension, thickness), p.velocity);
  for (const BoxParameters& p : boxes)
    add(box_of(p, physics.material(p.material), dimension, thickness), p.velocity);
}

void PlacedSurfaces::add(Surface surface, const std::vector<double>& velocity) {
  initial_.push_back(surface.position);
  velocity_.push_back(vector_of(velocity));
  surfaces_.push_back(std::move(surface));
}

void PlacedSurfaces::update(double time, double dt) {
  for (std::size_t k = 0; k < surfaces_.size(); ++k)
    for (std::size_t n = 0; n < initial_[k].size(); ++n) {
      surfaces_[k].position[n] = initial_[k][n] + time * velocity_[k];
      surfaces_[k].motion[n] = dt * velocity_[k];
    }
}

}  // namespace trackbed::bed
