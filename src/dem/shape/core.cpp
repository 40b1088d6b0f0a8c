// From the shape's geometry to the data of the kernels: flat arrays of small numbers, no normals
// and no neighbours. Both follow from the corners, and rotating them in each sub-step would cost
// more than they save.
#include "dem/shape/core.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace trackbed::dem {

namespace {

// The caller ensures that there are no more than `most_corners`.
std::uint8_t byte(int corner) { return static_cast<std::uint8_t>(corner); }

// Faces may be given in several parts in one plane: the lines between those are no edges and,
// treated as edges, would stiffen the face.
bool within_a_face(const geom::Convex& hull, const geom::Edge& edge) {
  constexpr double flat = 1e-6;  // rad
  if (edge.faces[0] < 0 || edge.faces[1] < 0) return false;
  const Vec3& one = hull.faces[static_cast<std::size_t>(edge.faces[0])].normal;
  const Vec3& other = hull.faces[static_cast<std::size_t>(edge.faces[1])].normal;
  return one.dot(other) > 0 && one.cross(other).norm() < flat;
}

}  // namespace

Core core_of(const geom::Piece& piece) {
  const geom::Convex& hull = piece.core;
  if (hull.vertices.empty() || hull.vertices.size() > most_corners)
    throw std::invalid_argument(
        fmt::format("a piece with {} core vertices: the number must be 1 to {}",
                    hull.vertices.size(), most_corners));
  if (!(piece.radius > 0)) throw std::invalid_argument("a piece without a rounding radius");
  Core core;
  core.radius = piece.radius;
  // Back to back: the two sides are equally far from any point, and one of them is sufficient.
  core.flat = hull.faces.size() == 2;
  for (const Vec3& v : hull.vertices) core.corners.push_back(vec4(v));
  for (const geom::Edge& e : hull.edges)
    if (!within_a_face(hull, e)) core.edges.push_back({byte(e.vertices[0]), byte(e.vertices[1])});
  const std::size_t faces = core.flat ? 1 : hull.faces.size();
  for (std::size_t f = 0; f < faces; ++f) {
    const std::vector<int>& v = hull.faces[f].vertices;
    // A fan from the first corner, valid for a convex face. Its inner lines are no edges and have
    // no effect.
    for (std::size_t k = 2; k < v.size(); ++k)
      core.triangles.push_back({byte(v[0]), byte(v[k - 1]), byte(v[k])});
  }
  if (hull.vertices.size() == 2) core.triangles.push_back({0, 1, 1});
  return core;
}

// Ritter's ball shrunk by steps towards the farthest corner (Badoiu, Clarkson 2003,
// doi:10.1145/644108.644240): within 1/steps of the smallest ball.
Vec4 ball_around(const Core& core) {
  constexpr int steps = 100;
  Vec3 centre = core.corners[0].vec3();
  const auto farthest = [&] {
    Vec3 at = centre;
    for (const Vec4& c : core.corners)
      if ((c.vec3() - centre).squaredNorm() > (at - centre).squaredNorm()) at = c.vec3();
    return at;
  };
  // A ball that is somewhat too large costs entries in a list but cannot miss a contact: the radius
  // is measured at the end. Cost: steps times corners, once for each template.
  for (int k = 1; k <= steps && core.corners.size() > 1; ++k)
    centre += (farthest() - centre) / (k + 1);
  Vec4 ball = vec4(centre);
  ball.w = (farthest() - centre).norm() + core.radius;
  return ball;
}

}  // namespace trackbed::dem
