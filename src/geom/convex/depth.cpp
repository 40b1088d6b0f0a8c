// Depth of points in a rounded convex piece, exactly.
//
// In the core the nearest point of the surface is on the plane of the nearest face, moved outwards
// by the radius. Beside the core the nearest of its points is the foot on a face whose plane the
// point is above, if the foot is within the face, or else on an edge. Cost: faces and edges per
// point, of which a stone has some dozens.
#include <algorithm>
#include <limits>

#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

namespace {

double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - t * along).norm();
}

// The cross product of edge and normal points out of the face: its corners are counter-clockwise
// seen from the tip of the normal.
bool within(const Convex& core, const Face& face, const Vec3& p) {
  const std::size_t n = face.vertices.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3& a = core.vertices[static_cast<std::size_t>(face.vertices[k])];
    const Vec3& b = core.vertices[static_cast<std::size_t>(face.vertices[(k + 1) % n])];
    if ((b - a).cross(face.normal).dot(p - a) > 0) return false;
  }
  return true;
}

// m, from the core; negative within it.
double distance(const Convex& core, double radius, const Vec3& p) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Face& face : core.faces) {
    const double height = face.normal.dot(p) - face.offset;
    if (height > radius) return height;  // outside the stone, at least as far
    highest = std::max(highest, height);
  }
  if (!core.faces.empty() && highest <= 0) return highest;
  double least = (p - core.vertices[0]).norm();
  for (const Edge& edge : core.edges)
    least = std::min(least, to_segment(p, core.vertices[static_cast<std::size_t>(edge.vertices[0])],
                                       core.vertices[static_cast<std::size_t>(edge.vertices[1])]));
  for (const Face& face : core.faces)
    if (const double height = face.normal.dot(p) - face.offset;
        height > 0 && height < least && within(core, face, p))
      least = height;
  return least;
}

}  // namespace

std::vector<double> depths(const Piece& piece, const std::vector<Vec3>& points) {
  std::vector<double> depths;
  depths.reserve(points.size());
  for (const Vec3& p : points)
    depths.push_back(piece.radius - distance(piece.core, piece.radius, p));
  return depths;
}

}  // namespace trackbed::geom
