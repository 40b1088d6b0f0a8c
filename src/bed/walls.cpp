// Rectangles of two triangles: floor, end walls, side walls.
// Two triangles each, as flat as they are: the coupler and the contacts know triangles only, and a
// second kind of wall would be a second code for the same contact. They reach beyond the bed, so
// that no stone finds an edge.
#include <algorithm>

#include "plate.hpp"
#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

// Counter-clockwise seen from the side of the stones, which is where normals point.
Surface plate(const std::string& name, int material, const Vec3& corner, const Vec3& first,
              const Vec3& second) {
  Surface surface;
  surface.name = name;
  surface.material = material;
  surface.position = {corner, corner + first, corner + first + second, corner + second};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  return surface;
}

// A plane model lies around y = 0.
// z is 0 in both corners.
Footprint footprint(const dem::Domain& domain) {
  const bool plane = domain.dimension == Dimension::plane;
  const double half = domain.thickness / 2;
  return {Vec3(domain.low.x(), plane ? -half : domain.low.y(), 0),
          Vec3(domain.high.x(), plane ? half : domain.high.y(), 0)};
}

// Up to `height` m, foot below the ground; the floor lies at z = 0. Names are found again in
// checkpoints.
std::vector<Surface> walls(const dem::Domain& domain, double height, int material, bool floor) {
  const Footprint inside = footprint(domain), outside = inside.grown(beyond);
  const Vec3 size = outside.high - outside.low;
  const Vec3 along(size.x(), 0, 0), across(0, size.y(), 0);
  // Down to where the domain ends: the ground below may settle.
  const double foot = std::min(domain.low.z(), -beyond);
  const Vec3 down(0, 0, foot), up(0, 0, height - foot);
  std::vector<Surface> all;
  if (floor) all.push_back(plate("floor", material, outside.low, along, across));
  if (!domain.periodic[0]) {
    const Vec3 left(inside.low.x(), outside.low.y(), 0), right(inside.high.x(), outside.low.y(), 0);
    all.push_back(plate("wall.left", material, left + down, across, up));    // normal +x
    all.push_back(plate("wall.right", material, right + down, up, across));  // normal -x
  }
  if (domain.dimension == Dimension::space && !domain.periodic[1]) {
    const Vec3 front(outside.low.x(), inside.low.y(), 0), back(outside.low.x(), inside.high.y(), 0);
    all.push_back(plate("wall.front", material, front + down, up, along));  // normal +y
    all.push_back(plate("wall.back", material, back + down, along, up));    // normal -y
  }
  return all;
}

}  // namespace trackbed::bed
